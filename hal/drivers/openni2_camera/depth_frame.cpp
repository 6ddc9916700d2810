#include "hal/drivers/openni2_camera/depth_frame.hpp"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "hal/drivers/openni2_camera/depth_image.hpp"

namespace colift::hal::openni2 {
namespace {

constexpr double kMinView_rad = 0.1, kMaxView_rad = 2.8;
constexpr std::uint16_t kSaturated = 0xffff;

}  // namespace

Result<> check(const PinholeModel& model) {
  if (std::string why = impossible(model.intrinsics, model.lens); !why.empty())
    return failure(ErrorCode::BadConfig, "openni2.intrinsics", std::move(why));
  return {};
}

bool plausible(const FieldOfView& view) {
  return view.across_rad >= kMinView_rad && view.across_rad <= kMaxView_rad &&
         view.down_rad >= kMinView_rad && view.down_rad <= kMaxView_rad;
}

CameraIntrinsics intrinsics_of(const FieldOfView& view, int width, int height) {
  return {width,
          height,
          0.5 * width / std::tan(0.5 * view.across_rad),
          0.5 * height / std::tan(0.5 * view.down_rad),
          0.5 * width,
          0.5 * height};
}

Result<std::vector<float>> depth_of(const capture::RawFrame& raw, const PinholeModel& model, double min_m,
                                    double max_m) {
  const auto wrong = [](std::string what) {
    return failure(ErrorCode::BadReply, "openni2.frame", std::move(what));
  };
  const CameraIntrinsics& k = model.intrinsics;
  if (raw.stamp.unit_um != kUnit_1mm && raw.stamp.unit_um != kUnit_100um)
    return wrong(fmt::format("a depth unit of {} um, expected 1000 or 100", raw.stamp.unit_um));
  if (raw.stamp.width != static_cast<std::uint32_t>(k.width) ||
      raw.stamp.height != static_cast<std::uint32_t>(k.height) ||
      raw.pixels.size() != static_cast<std::size_t>(k.width) * static_cast<std::size_t>(k.height))
    return wrong(fmt::format("a frame of {} x {} pixels, and its intrinsics are of {} x {}", raw.stamp.width,
                             raw.stamp.height, k.width, k.height));
  const double unit_m = 1e-6 * raw.stamp.unit_um;
  std::vector<float> depth_m(raw.pixels.size(), std::numeric_limits<float>::quiet_NaN());
  for (std::size_t i = 0; i < depth_m.size(); ++i) {
    const std::uint16_t units = raw.pixels[i];
    if (units == 0 || units == kSaturated) continue;
    const double z = units * unit_m;
    if (z >= min_m && z <= max_m) depth_m[i] = static_cast<float>(z);
  }
  if (!model.lens.none()) return rectify(depth_m, k, model.lens);
  return depth_m;
}

}  // namespace colift::hal::openni2
