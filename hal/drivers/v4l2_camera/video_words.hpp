#pragma once

#include <cstdint>
#include <string>

#include "hal/types/result.hpp"

namespace colift::hal::v4l2 {

/// "VIDIOC_S_FMT" of a request; its number in hexadecimal of one that the driver does not use.
[[nodiscard]] const char* name_of(unsigned long request);

/// "Z16 " of a four-character code, unprintable bytes as '?'.
[[nodiscard]] std::string text_of(std::uint32_t four_characters);

/// A failed open() as a sentence with what to do. LinkLost: there is no such device now; BadConfig: never
/// will be; DeviceFault: it is there and refuses.
[[nodiscard]] Error open_error(const std::string& path, int error_number);

/// A failed call on an open device, likewise. LinkLost: it is gone.
[[nodiscard]] Error call_error(const std::string& path, unsigned long request, int error_number);

}  // namespace colift::hal::v4l2
