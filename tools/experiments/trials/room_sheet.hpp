#pragma once

#include <functional>
#include <string>
#include <vector>

#include "sim_hal/synthetic/rooms.hpp"
#include "tools/experiments/experiment.hpp"

namespace colift::experiments {

/// How often a room got one of these verdicts, of those with a value in a column; of all where the value is
/// empty.
[[nodiscard]] Estimate verdict_share(const Results& results, const std::string& column,
                                     const std::string& value, const std::vector<std::string>& verdicts);

/// Contact sheet of the rooms that went wrong: a person as the target first, then something else, then what
/// was missed. Depth in grey, the true object bluish, persons reddish, what was taken as the target green.
/// The table has the columns seed, class, verdict and room.
[[nodiscard]] picture::Canvas room_sheet(const Results& results,
                                         const std::function<sim_hal::RandomRoom(std::uint64_t)>& make);

}  // namespace colift::experiments
