#include "hal/drivers/v4l2_camera/z16_image.hpp"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <utility>

namespace colift::hal::v4l2 {
namespace {

constexpr double kMinUnit_m = 1e-6, kMaxUnit_m = 0.1;
constexpr unsigned kSaturated = 0xffff;

}  // namespace

Result<> check(const DepthModel& model) {
  const auto wrong = [](std::string what) {
    return failure(ErrorCode::BadConfig, "v4l2.intrinsics", std::move(what));
  };
  if (std::string why = impossible(model.intrinsics, model.lens); !why.empty()) return wrong(std::move(why));
  if (!(model.unit_m >= kMinUnit_m && model.unit_m <= kMaxUnit_m))
    return wrong(
        fmt::format("a depth unit of {} m; expected {} to {}", model.unit_m, kMinUnit_m, kMaxUnit_m));
  return {};
}

Result<std::vector<float>> depth_of(const Z16View& picture, const DepthModel& model,
                                    const DepthRange& range) {
  const auto wrong = [](std::string what) {
    return failure(ErrorCode::BadReply, "v4l2.image", std::move(what));
  };
  const CameraIntrinsics& k = model.intrinsics;
  const auto width = static_cast<std::size_t>(k.width), height = static_cast<std::size_t>(k.height);
  if (picture.stride < 2 * width)
    return wrong(fmt::format("rows of {} bytes; {} pixels have {}", picture.stride, width, 2 * width));
  if (picture.bytes.size() < bytes_of(k, picture.stride))
    return wrong(fmt::format("{} bytes; {} rows of {} have {}", picture.bytes.size(), height, picture.stride,
                             bytes_of(k, picture.stride)));
  std::vector<float> depth_m(width * height, std::numeric_limits<float>::quiet_NaN());
  for (std::size_t v = 0; v < height; ++v) {
    const std::uint8_t* from = picture.bytes.data() + v * picture.stride;
    float* const to = depth_m.data() + v * width;
    for (std::size_t u = 0; u < width; ++u, from += 2) {
      const unsigned units = from[0] | (static_cast<unsigned>(from[1]) << 8U);
      if (units == 0 || units == kSaturated) continue;
      const double depth = units * model.unit_m;
      if (depth >= range.min_m && depth <= range.max_m) to[u] = static_cast<float>(depth);
    }
  }
  if (!model.lens.none()) return rectify(depth_m, k, model.lens);
  return depth_m;
}

}  // namespace colift::hal::v4l2
