#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace colift::hal::openni2 {

// What OpenNI2 hands out, looked at before it is used. Without OpenNI2's headers: for the capture process and
// for tests.

inline constexpr int kMinSide = 16, kMaxSide = 4096;                 // pixels
inline constexpr std::uint32_t kMaxPixels = 1280 * 1024;             ///< Of the largest image that is taken.
inline constexpr std::uint32_t kUnit_1mm = 1000, kUnit_100um = 100;  ///< Depth of one unit (um).

/// A way in which a device gives depth.
struct DepthMode {
  int width = 0, height = 0;
  int rate_hz = 0;
  std::uint32_t unit_um = 0;  ///< 0: not depth in metres.
};

/// "640 x 480 at 30 Hz in 1 mm".
[[nodiscard]] std::string text_of(const DepthMode& mode);

/// What is wanted of it; 0: anything.
struct WantedMode {
  int width = 0, height = 0, rate_hz = 0;
  std::uint32_t unit_um = 0;
};

/// Which of the offered modes is taken: of those that fit the one nearest to 640 x 480 at 30 Hz, in whole
/// millimetres before tenths, which end at 6.5 m. Nothing when none fits.
[[nodiscard]] std::optional<std::size_t> choose_mode(std::span<const DepthMode> offered,
                                                     const WantedMode& wanted);

/// An image as OpenNI2 describes it.
struct ImageView {
  const void* data = nullptr;
  int bytes = 0;
  int width = 0, height = 0;
  int stride = 0;  ///< Bytes from one row to the next.
  bool cropped = false;
};

/// Copies the pixels into `to`, row by row, left to right as the camera sees: of a mirrored image each row
/// backwards. The reason when it is not an image of `mode`; `to` is then as it was.
[[nodiscard]] std::optional<std::string> copy_image(const ImageView& image, const DepthMode& mode,
                                                    bool mirrored, std::vector<std::uint16_t>& to);

}  // namespace colift::hal::openni2
