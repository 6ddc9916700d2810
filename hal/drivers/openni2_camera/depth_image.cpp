#include "hal/drivers/openni2_camera/depth_image.hpp"

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <tuple>

namespace colift::hal::openni2 {

std::string text_of(const DepthMode& m) {
  const std::string unit = m.unit_um == kUnit_1mm     ? " in 1 mm"
                           : m.unit_um == kUnit_100um ? " in 0.1 mm"
                                                      : " in units that are no length";
  return std::to_string(m.width) + " x " + std::to_string(m.height) + " at " + std::to_string(m.rate_hz) +
         " Hz" + unit;
}

std::optional<std::size_t> choose_mode(std::span<const DepthMode> offered, const WantedMode& wanted) {
  constexpr int kWidth = 640, kHeight = 480, kRate_hz = 30;
  const auto fits = [&](const DepthMode& m) {
    const bool possible = m.width >= kMinSide && m.width <= kMaxSide && m.height >= kMinSide &&
                          m.height <= kMaxSide &&
                          static_cast<std::uint32_t>(m.width * m.height) <= kMaxPixels;
    return possible && (m.unit_um == kUnit_1mm || m.unit_um == kUnit_100um) &&
           (wanted.width == 0 || m.width == wanted.width) &&
           (wanted.height == 0 || m.height == wanted.height) &&
           (wanted.rate_hz == 0 || m.rate_hz == wanted.rate_hz) &&
           (wanted.unit_um == 0 || m.unit_um == wanted.unit_um);
  };
  const auto distance = [&](const DepthMode& m) {
    return std::tuple(std::abs(m.width - kWidth) + std::abs(m.height - kHeight),
                      std::abs(m.rate_hz - kRate_hz), m.unit_um == kUnit_1mm ? 0 : 1);
  };
  std::optional<std::size_t> best;
  for (std::size_t i = 0; i < offered.size(); ++i)
    if (fits(offered[i]) && (!best || distance(offered[i]) < distance(offered[*best]))) best = i;
  return best;
}

std::optional<std::string> copy_image(const ImageView& image, const DepthMode& mode, bool mirrored,
                                      std::vector<std::uint16_t>& to) {
  if (image.cropped) return "a frame that is cut out of the image";
  if (image.width != mode.width || image.height != mode.height)
    return "a frame of " + std::to_string(image.width) + " x " + std::to_string(image.height) +
           " pixels, expected " + std::to_string(mode.width) + " x " + std::to_string(mode.height);
  const auto width = static_cast<std::size_t>(mode.width), height = static_cast<std::size_t>(mode.height);
  const std::size_t stride = image.stride > 0 ? static_cast<std::size_t>(image.stride) : 0;
  const std::size_t bytes = image.bytes > 0 ? static_cast<std::size_t>(image.bytes) : 0;
  if (image.data == nullptr || stride < 2 * width || bytes < stride * (height - 1) + 2 * width)
    return "a frame of " + std::to_string(image.bytes) + " bytes in rows of " + std::to_string(image.stride) +
           ", which are not " + std::to_string(mode.width) + " x " + std::to_string(mode.height) + " pixels";
  to.resize(width * height);
  for (std::size_t v = 0; v < height; ++v) {
    std::uint16_t* const row = to.data() + v * width;
    std::memcpy(row, static_cast<const char*>(image.data) + v * stride, 2 * width);
    if (mirrored) std::reverse(row, row + width);
  }
  return std::nullopt;
}

}  // namespace colift::hal::openni2
