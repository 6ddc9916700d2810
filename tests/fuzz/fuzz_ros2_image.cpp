// Any values as a camera model and an image of ROS 2: refused with a reason, or a depth image of the model's
// size without a depth that cannot be.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <span>

#include "hal/drivers/ros2_camera/ros2_image.hpp"
#include "tests/fuzz/demand.hpp"

namespace {

using colift::fuzz::demand;
using namespace colift::hal;

/// Takes values off the front of the input; zeros behind its end.
struct Bytes {
  const std::uint8_t* at;
  std::size_t left;

  template <class T>
  T take() {
    T value{};
    const std::size_t n = std::min(left, sizeof(T));
    std::memcpy(&value, at, n);
    at += n;
    left -= n;
    return value;
  }
};

constexpr std::array kEncodings{"16UC1", "32FC1", "mono16", "", "16UC1 "};
constexpr std::array kModels{"plumb_bob", "rational_polynomial", "equidistant", "", "none"};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  Bytes in{data, size};
  ros2::InfoView info;
  info.distortion_model = kModels[in.take<std::uint8_t>() % kModels.size()];
  info.width = in.take<std::uint16_t>();
  info.height = in.take<std::uint16_t>();
  for (double& k : info.k) k = in.take<double>();
  std::array<double, 14> d{};
  const std::size_t coefficients = in.take<std::uint8_t>() % (d.size() + 1);
  for (std::size_t i = 0; i < coefficients; ++i) d[i] = in.take<double>();
  info.d = std::span(d).first(coefficients);
  info.binning_x = in.take<std::uint8_t>();
  info.binning_y = in.take<std::uint8_t>();
  info.roi_width = in.take<std::uint16_t>();
  info.roi_height = in.take<std::uint16_t>();
  const auto model = ros2::model_of(info);
  if (!model) {
    demand(!model.error().detail.empty());
    return 0;
  }
  const CameraIntrinsics& camera = model->intrinsics;
  demand(camera.width >= ros2::kMinSide && camera.width <= ros2::kMaxSide && camera.fx > 0.0 &&
         std::isfinite(camera.fx) && std::isfinite(camera.cy));

  ros2::ImageView image;
  image.encoding = kEncodings[in.take<std::uint8_t>() % kEncodings.size()];
  image.width = in.take<std::uint8_t>() % 2 == 0 ? info.width : in.take<std::uint32_t>();
  image.height = in.take<std::uint8_t>() % 2 == 0 ? info.height : in.take<std::uint32_t>();
  image.step = in.take<std::uint32_t>();
  image.is_bigendian = in.take<std::uint8_t>();
  image.data = {in.at, in.left};
  const auto depth = ros2::depth_of(image, *model);
  if (!depth) {
    demand(!depth.error().detail.empty());
    return 0;
  }
  demand(depth->size() == static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(camera.height));
  demand(std::all_of(depth->begin(), depth->end(),
                     [](float z) { return std::isnan(z) || (z > 0.0F && std::isfinite(z)); }));
  return 0;
}
