#include "hal/drivers/ros2_camera/ros2_image.hpp"

#include <fmt/format.h>

#include <bit>
#include <cmath>
#include <limits>

namespace colift::hal::ros2 {
namespace {

constexpr float kMaxDepth_m = 100.0f;
constexpr double kMinFocal_px = 10.0, kMaxFocal_px = 20000.0, kMaxSkew_px = 0.5, kMaxCoefficient = 100.0;

tl::unexpected<Error> wrong_info(std::string what) {
  return failure(ErrorCode::BadReply, "ros2.camera_info", std::move(what));
}
tl::unexpected<Error> wrong_image(std::string what) {
  return failure(ErrorCode::BadReply, "ros2.image", std::move(what));
}

bool is_size(std::uint32_t width, std::uint32_t height) {
  return width >= kMinSide && width <= kMaxSide && height >= kMinSide && height <= kMaxSide;
}

/// Of a text that came from the network: short, and printable in any case.
std::string shown(std::string_view text) {
  std::string out;
  for (const char c : text.substr(0, 40)) out.push_back(c >= 0x20 && c < 0x7f ? c : '?');
  return out;
}

Result<LensDistortion> lens_of(const InfoView& info) {
  for (const double k : info.d)
    if (!std::isfinite(k) || std::abs(k) > kMaxCoefficient)
      return wrong_info(fmt::format("distortion coefficient {} (limit {})", k, kMaxCoefficient));
  const bool any = std::any_of(info.d.begin(), info.d.end(), [](double k) { return k != 0.0; });
  if (!any) return LensDistortion{};
  const bool rational = info.distortion_model == "rational_polynomial";
  if (!rational && info.distortion_model != "plumb_bob")
    return wrong_info(fmt::format("distortion model '{}'; expected plumb_bob or rational_polynomial",
                                  shown(info.distortion_model)));
  if (info.d.size() != (rational ? 8u : 5u))
    return wrong_info(fmt::format("{} distortion coefficients; {} has {}", info.d.size(),
                                  info.distortion_model, rational ? 8 : 5));
  const auto d = info.d;
  LensDistortion lens{d[0], d[1], d[2], d[3], d[4], 0.0, 0.0, 0.0};
  if (rational) lens.k4 = d[5], lens.k5 = d[6], lens.k6 = d[7];
  return lens;
}

template <class Word>
Word word_at(const std::uint8_t* from, bool big) {
  Word value = 0;
  for (std::size_t i = 0; i < sizeof(Word); ++i) {
    const std::size_t at = big ? i : sizeof(Word) - 1 - i;
    value = static_cast<Word>((value << 8) | from[at]);
  }
  return value;
}

}  // namespace

bool CameraModel::operator==(const CameraModel& o) const {
  const auto all = [](const CameraModel& m) {
    const CameraIntrinsics& c = m.intrinsics;
    const LensDistortion& l = m.lens;
    return std::array<double, 14>{static_cast<double>(c.width),
                                  static_cast<double>(c.height),
                                  c.fx,
                                  c.fy,
                                  c.cx,
                                  c.cy,
                                  l.k1,
                                  l.k2,
                                  l.p1,
                                  l.p2,
                                  l.k3,
                                  l.k4,
                                  l.k5,
                                  l.k6};
  };
  return all(*this) == all(o);
}

Result<CameraModel> model_of(const InfoView& info) {
  if (!is_size(info.width, info.height))
    return wrong_info(
        fmt::format("size {} x {}; expected {} to {}", info.width, info.height, kMinSide, kMaxSide));
  for (const double k : info.k)
    if (!std::isfinite(k)) return wrong_info("a value of K is not finite");
  const auto& k = info.k;
  if (k[0] == 0.0) return wrong_info("K is zero: the camera is not calibrated");
  if (!(k[0] > kMinFocal_px && k[0] < kMaxFocal_px && k[4] > kMinFocal_px && k[4] < kMaxFocal_px))
    return wrong_info(
        fmt::format("focal lengths {} and {} px; expected {} to {}", k[0], k[4], kMinFocal_px, kMaxFocal_px));
  if (std::abs(k[1]) > kMaxSkew_px || k[3] != 0.0 || k[6] != 0.0 || k[7] != 0.0 || k[8] != 1.0)
    return wrong_info("K is no matrix of a pinhole camera without skew");
  if (!(k[2] >= 0.0 && k[2] <= info.width && k[5] >= 0.0 && k[5] <= info.height))
    return wrong_info(fmt::format("principal point ({}, {}) outside the image", k[2], k[5]));
  if (info.binning_x > 1 || info.binning_y > 1)
    return wrong_info(fmt::format("binning {} x {}; expected none", info.binning_x, info.binning_y));
  const bool no_region = info.roi_x == 0 && info.roi_y == 0 &&
                         (info.roi_width == 0 || info.roi_width == info.width) &&
                         (info.roi_height == 0 || info.roi_height == info.height);
  if (!no_region) return wrong_info("a region of interest; expected the whole image");
  CameraModel model;
  model.intrinsics = {static_cast<int>(info.width), static_cast<int>(info.height), k[0], k[4], k[2], k[5]};
  const auto lens = lens_of(info);
  if (!lens) return tl::unexpected(lens.error());
  model.lens = *lens;
  if (!model.lens.none() && !model.lens.unique_within(model.intrinsics))
    return wrong_info("the distortion maps two rays to one pixel");
  return model;
}

Result<std::vector<float>> depth_of(const ImageView& image, const CameraModel& camera) {
  if (!is_size(image.width, image.height))
    return wrong_image(
        fmt::format("size {} x {}; expected {} to {}", image.width, image.height, kMinSide, kMaxSide));
  if (image.width != static_cast<std::uint32_t>(camera.intrinsics.width) ||
      image.height != static_cast<std::uint32_t>(camera.intrinsics.height))
    return wrong_image(fmt::format("{} x {} pixels, the camera's model has {} x {}", image.width,
                                   image.height, camera.intrinsics.width, camera.intrinsics.height));
  const bool millimetres = image.encoding == "16UC1";
  if (!millimetres && image.encoding != "32FC1")
    return wrong_image(fmt::format("encoding '{}'; expected 16UC1 or 32FC1", shown(image.encoding)));
  if (image.is_bigendian > 1) return wrong_image(fmt::format("is_bigendian {}", image.is_bigendian));
  const std::size_t pixel = millimetres ? 2 : 4, row = pixel * image.width, step = image.step;
  if (step < row || step > 4 * row)
    return wrong_image(fmt::format("step {}, a row has {} bytes", image.step, row));
  if (image.data.size() != step * image.height)
    return wrong_image(fmt::format("{} bytes, {} rows of {} have {}", image.data.size(), image.height, step,
                                   step * image.height));
  const bool big = image.is_bigendian == 1;
  std::vector<float> depth_m(std::size_t{image.width} * image.height,
                             std::numeric_limits<float>::quiet_NaN());
  for (std::size_t v = 0; v < image.height; ++v) {
    const std::uint8_t* from = image.data.data() + v * step;
    float* to = depth_m.data() + v * image.width;
    for (std::size_t u = 0; u < image.width; ++u, from += pixel) {
      if (millimetres) {
        const auto mm = word_at<std::uint16_t>(from, big);
        if (mm != 0) to[u] = static_cast<float>(mm / 1000.0);
      } else {
        const auto d = std::bit_cast<float>(word_at<std::uint32_t>(from, big));
        if (d > 0.0f && d < kMaxDepth_m) to[u] = d;  // none of NaN, infinite, negative
      }
    }
  }
  if (!camera.lens.none()) return rectify(depth_m, camera.intrinsics, camera.lens);
  return depth_m;
}

}  // namespace colift::hal::ros2
