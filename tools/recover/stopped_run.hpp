#pragma once

#include <string>

#include "tools/cli/session.hpp"
#include "tools/rig/back_ends.hpp"

namespace colift::tools {

/// `run --recover`: recovers a simulated rig whose run has just stopped, every step confirmed. Returns the
/// document of the recovery, with the simulation's truth before each step.
[[nodiscard]] std::string recover_stopped_run(Rig& rig, const Setup& setup, std::uint64_t seed,
                                              hal::Timestamp began, bool quiet);

}  // namespace colift::tools
