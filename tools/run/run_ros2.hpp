#pragma once

#include "tools/run/run_parts.hpp"

namespace colift::tools {

/// RunParts::open_ros2.
[[nodiscard]] hal::Result<std::unique_ptr<Ros2View>> open_ros2(const RunOptions& options);

}  // namespace colift::tools
