#pragma once

#include <string>
#include <string_view>

#include "hal/types/result.hpp"
#include "sim_hal/emulator/fault_text.hpp"

namespace colift::sim_hal {

/// Something that goes wrong with a video device at a time.
struct VideoFault : TimedFault {
  enum class Kind {
    // of the device
    Unplug,  ///< Gone from the bus; afterwards another one of the same name.
    Silent,  ///< No images.
    Slow,    ///< `value` images a second.
    Late,    ///< Images come `value` ms later.
    Hang,    ///< A call does not come back.
    // of its buffers
    Short,    ///< `value` percent of an image's bytes.
    Damaged,  ///< Marked by the kernel as damaged, with half an image in them.
    Jump,     ///< Stamps are off by `value` ms.
    Restamp,  ///< New images, the same stamp.
    Foreign,  ///< Stamps of another clock.
    // of the picture
    Blind,   ///< No pixel sees anything.
    Freeze,  ///< The same picture, new stamps.
  };

  Kind kind = Kind::Silent;
};

/// Reads "T:KIND[=VALUE][:DURATION]", times in s; 0.5 s. Errors: BadInput, with what was expected.
[[nodiscard]] hal::Result<VideoFault> parse_video_fault(std::string_view text);

/// One entry of a scenario's `faults` for the camera. Errors: BadConfig.
[[nodiscard]] hal::Result<VideoFault> video_fault(const DeviceFaultEvent& event);

}  // namespace colift::sim_hal
