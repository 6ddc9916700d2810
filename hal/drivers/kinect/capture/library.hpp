#pragma once

#include <libfreenect.h>
#include <libfreenect_registration.h>

#include <optional>
#include <string>

#include "hal/drivers/kinect/depth_table.hpp"

namespace colift::capture {

// Calls that Debian's fakenect lacks: looked up when they are wanted, so that one program runs with either.

/// Serial of the first camera; empty when the library cannot tell.
[[nodiscard]] std::string first_serial(freenect_context* context);

/// What the device says of its geometry.
[[nodiscard]] std::optional<hal::kinect::DepthConstants> constants_of(freenect_device* device);

/// False when the library cannot.
[[nodiscard]] bool set_ir_brightness(freenect_device* device, int brightness);

/// A mode of the device, found by enumeration: asking for one that is not there ends the process in fakenect.
[[nodiscard]] std::optional<freenect_frame_mode> depth_mode();
[[nodiscard]] std::optional<freenect_frame_mode> infrared_mode();

}  // namespace colift::capture
