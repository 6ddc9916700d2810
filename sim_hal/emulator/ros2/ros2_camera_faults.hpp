#pragma once

#include <string_view>

#include "hal/types/result.hpp"
#include "sim_hal/emulator/fault_text.hpp"

namespace colift::sim_hal {

/// Something that goes wrong at a time with a camera's driver of ROS 2, or between it and CoLift.
struct Ros2CameraFault : TimedFault {
  enum class Kind {
    // of the driver
    Unplug,  ///< Its node is gone; afterwards another one of the same name.
    Silent,  ///< No images, and its node is there.
    Slow,    ///< `value` images a second.
    Late,    ///< Images come `value` ms after their stamps.
    // of its messages
    Jump,     ///< Stamps are off by `value` ms.
    Restamp,  ///< New images, the same stamp.
    Short,    ///< `value` percent of an image's bytes.
    Resized,  ///< A camera model of another size.
    // of the picture
    Blind,   ///< No pixel sees anything.
    Freeze,  ///< The same picture, new stamps.
  };

  Kind kind = Kind::Silent;
};

/// Reads "T:KIND[=VALUE][:DURATION]", times in s; 0.5 s. Errors: BadInput, with what was expected.
[[nodiscard]] hal::Result<Ros2CameraFault> parse_ros2_camera_fault(std::string_view text);

/// One entry of a scenario's `faults` for the camera. Errors: BadConfig.
[[nodiscard]] hal::Result<Ros2CameraFault> ros2_camera_fault(const DeviceFaultEvent& event);

}  // namespace colift::sim_hal
