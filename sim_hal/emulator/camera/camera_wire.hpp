#pragma once

#include <cstdint>

namespace colift::sim_hal {

// Between CameraServer and the library that stands in for libfreenect (freenect/): messages on a local stream
// socket, a head and its bytes each, of one machine and one build.

inline constexpr std::uint32_t kCameraWireMagic = 0x31434c43;
inline constexpr const char* kCameraWireVariable = "COLIFT_KINECT_EMULATOR";  ///< Names the socket: "@NAME".
inline constexpr std::uint32_t kCameraWireMost = 640 * 488 * 2;               ///< Bytes after a head.

enum class CameraMessage : std::uint32_t {
  // from the server
  Hello = 1,     ///< A Kinect is on the bus: CameraHello.
  Absent = 2,    ///< None is.
  Depth = 3,     ///< 640 x 480 raw codes; `value` is the device's counter.
  Infrared = 4,  ///< 640 x 488 of ten bits; `value` as above.
  Tilt = 5,      ///< CameraTilt.
  Log = 6,       ///< A line of the library's log; `value` is its level.
  Unplug = 7,    ///< From now on the device is gone.
  Hang = 8,      ///< The library does not come back from a call, for `value` ms.
  Crash = 9,     ///< It breaks a segment.
  // from the library
  Want = 16,        ///< `value`: bit 0 depth, bit 1 infrared.
  SetTilt = 17,     ///< `value`: degrees, as an int32.
  Brightness = 18,  ///< `value`: 1 to 50.
};

struct CameraHead {
  std::uint32_t magic = kCameraWireMagic;
  CameraMessage what = CameraMessage::Absent;
  std::uint32_t bytes = 0;  ///< That follow.
  std::uint32_t value = 0;
};

struct CameraTilt {
  std::int16_t x = 0, y = 819, z = 0;  ///< Counts, 819 to a g.
  std::int8_t half_degrees = 0, pad = 0;
};

struct CameraHello {
  double emitter_cm = 7.5, reference_cm = 120.0, pixel_cm = 0.1042, shift = 200.0;
  char serial[32] = "";
  CameraTilt tilt;
};

}  // namespace colift::sim_hal
