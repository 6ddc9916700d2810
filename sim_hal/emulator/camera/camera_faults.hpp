#pragma once

#include <string>
#include <string_view>

#include "hal/types/result.hpp"
#include "sim_hal/emulator/fault_text.hpp"

namespace colift::sim_hal {

/// Something that goes wrong with the camera at a time.
struct CameraFault : TimedFault {
  enum class Kind {
    // of the device
    Unplug,   ///< Gone from the bus; afterwards back.
    Silent,   ///< No frames.
    Slow,     ///< `value` frames a second.
    Late,     ///< Frames come `value` ms later.
    Double,   ///< Each comes twice.
    Swap,     ///< Neighbours change places.
    Packets,  ///< `value` USB packets of each frame are lost.
    Short,    ///< Frames end after half of their rows; libfreenect hands out none of these.
    Clock,    ///< The device's counter is set by `value` s, and stays so.
    // of the picture
    Blind,    ///< No pixel sees anything.
    Zeros,    ///< All codes are 0.
    Half,     ///< `value` percent of the pixels see nothing, in blots.
    Corrupt,  ///< `value` percent of the pixels hold any code.
    Freeze,   ///< The same picture, new times.
    Restamp,  ///< New pictures, the same time.
    Moved,    ///< Turned by `value` degrees, and stays so.
    // of the library in the capture process
    Hang,   ///< A call does not come back.
    Crash,  ///< Once, at the beginning.
  };

  Kind kind = Kind::Silent;
};

/// Reads "T:KIND[=VALUE][:DURATION]", times in s; 0.5 s. Errors: BadInput, with what was expected.
[[nodiscard]] hal::Result<CameraFault> parse_camera_fault(std::string_view text);

/// One entry of a scenario's `faults` for the camera. Errors: BadConfig.
[[nodiscard]] hal::Result<CameraFault> camera_fault(const DeviceFaultEvent& event);

}  // namespace colift::sim_hal
