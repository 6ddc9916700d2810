#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "hal/lens.hpp"
#include "sim_hal/imperfect/imperfect_devices.hpp"

namespace colift::sim_hal {
namespace {

class ImperfectCamera final : public hal::DepthCamera {
 public:
  ImperfectCamera(std::unique_ptr<hal::DepthCamera> inner, const CameraErrors& errors)
      : inner_(std::move(inner)), errors_(errors) {}

  hal::Result<> configure() override { return inner_->configure(); }
  hal::Result<> activate() override { return inner_->activate(); }
  void deactivate() noexcept override { inner_->deactivate(); }
  hal::DeviceHealth health() const override { return inner_->health(); }

  hal::Result<hal::DepthFrame> next_frame(std::chrono::milliseconds timeout) override {
    auto frame = inner_->next_frame(timeout);
    if (!frame) return frame;
    const auto& k = frame->intrinsics;
    // a frame that a fault cut short is passed on as it is
    if (frame->depth_m.size() == static_cast<std::size_t>(k.width) * static_cast<std::size_t>(k.height))
      distort(*frame);
    const auto scale = static_cast<float>(1.0 + errors_.depth_scale);
    for (float& z : frame->depth_m) z *= scale;
    frame->intrinsics.fx *= 1.0 + errors_.focal_length;
    frame->intrinsics.fy *= 1.0 + errors_.focal_length;
    frame->exposed_at += std::chrono::duration_cast<hal::Duration>(
        std::chrono::microseconds(std::llround(1e6 * errors_.clock_skew_s)));
    return frame;
  }

 private:
  /// Every pixel shows the ray that the lens leads there; nearest pixel, as depth has edges.
  void distort(hal::DepthFrame& frame) {
    if (errors_.distortion == 0.0) return;
    const auto& k = frame.intrinsics;
    if (sources_.size() != frame.depth_m.size()) find_sources(k);
    std::vector<float> seen(frame.depth_m.size(), std::numeric_limits<float>::quiet_NaN());
    for (std::size_t i = 0; i < seen.size(); ++i)
      if (sources_[i] < seen.size()) seen[i] = frame.depth_m[sources_[i]];
    frame.depth_m = std::move(seen);
  }

  /// One camera has one size of images.
  void find_sources(const hal::CameraIntrinsics& k) {
    hal::LensDistortion lens;
    lens.k1 = errors_.distortion;
    sources_.clear();
    for (int v = 0; v < k.height; ++v) {
      for (int u = 0; u < k.width; ++u) {
        const auto [x, y] = lens.undistort((u - k.cx) / k.fx, (v - k.cy) / k.fy);
        const auto from_u = std::lround(k.cx + k.fx * x), from_v = std::lround(k.cy + k.fy * y);
        const bool inside = from_u >= 0 && from_v >= 0 && from_u < k.width && from_v < k.height;
        sources_.push_back(inside ? static_cast<std::size_t>(from_v * k.width + from_u)
                                  : std::numeric_limits<std::size_t>::max());
      }
    }
  }

  std::unique_ptr<hal::DepthCamera> inner_;
  CameraErrors errors_;
  std::vector<std::size_t> sources_;  // of each pixel; beyond the image: none
};

}  // namespace

std::unique_ptr<hal::DepthCamera> make_imperfect_camera(std::unique_ptr<hal::DepthCamera> inner,
                                                        const CameraErrors& errors) {
  return std::make_unique<ImperfectCamera>(std::move(inner), errors);
}

}  // namespace colift::sim_hal
