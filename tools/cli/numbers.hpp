#pragma once

#include <string>
#include <vector>

#include "hal/types/geometry.hpp"
#include "hal/types/result.hpp"

namespace colift::tools {

/// "1.5,-2,3e-1" as numbers. Errors: BadInput unless there are exactly `count` finite ones; `option` is
/// `where`.
[[nodiscard]] hal::Result<std::vector<double>> parse_numbers(const std::string& text, std::size_t count,
                                                             const std::string& option);

[[nodiscard]] hal::Result<hal::Vec3> parse_point(const std::string& text, const std::string& option);

/// "X,Y,Z,QX,QY,QZ,QW". Errors: BadInput; also for a quaternion whose length is not within 1 % of one.
[[nodiscard]] hal::Result<hal::Pose> parse_pose(const std::string& text, const std::string& option);

}  // namespace colift::tools
