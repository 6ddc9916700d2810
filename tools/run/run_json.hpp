#pragma once

#include <string>

#include "tools/run/run_view.hpp"

namespace colift::tools {

/// The document colift.run/1, one line, without a line end. What did not happen is null; a number is never
/// NaN. Only timing.wall_s, timing.decision_compute_ms and timing.plan_ms depend on the machine.
[[nodiscard]] std::string run_document(const RunView& view);

}  // namespace colift::tools
