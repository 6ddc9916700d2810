#pragma once

#include <cstddef>
#include <string>

namespace colift::hal {

/// Name of a robot's camera in messages, recordings and faults: "camera", then "camera2" for the first of
/// Robot::more_cameras.
[[nodiscard]] inline std::string camera_name(std::size_t camera) {
  return camera == 0 ? "camera" : "camera" + std::to_string(camera + 1);
}

}  // namespace colift::hal
