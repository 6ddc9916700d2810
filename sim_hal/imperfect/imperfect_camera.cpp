#include <cmath>
#include <limits>
#include <utility>
#include <vector>

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
  /// Every pixel shows the ray that the lens leads there: undistorted radius r (1 - k1 r^2), the first-order
  /// inverse of r (1 + k1 r^2); nearest pixel, as depth has edges.
  void distort(hal::DepthFrame& frame) const {
    if (errors_.distortion == 0.0) return;
    const auto k = frame.intrinsics;
    std::vector<float> seen(frame.depth_m.size(), std::numeric_limits<float>::quiet_NaN());
    for (int v = 0; v < k.height; ++v) {
      for (int u = 0; u < k.width; ++u) {
        const double x = (u - k.cx) / k.fx, y = (v - k.cy) / k.fy;
        const double s = 1.0 - errors_.distortion * (x * x + y * y);
        const auto from_u = std::lround(k.cx + k.fx * x * s), from_v = std::lround(k.cy + k.fy * y * s);
        if (from_u < 0 || from_v < 0 || from_u >= k.width || from_v >= k.height) continue;
        seen[static_cast<std::size_t>(v * k.width + u)] =
            frame.depth_m[static_cast<std::size_t>(from_v * k.width + from_u)];
      }
    }
    frame.depth_m = std::move(seen);
  }

  std::unique_ptr<hal::DepthCamera> inner_;
  CameraErrors errors_;
};

}  // namespace

std::unique_ptr<hal::DepthCamera> make_imperfect_camera(std::unique_ptr<hal::DepthCamera> inner,
                                                        const CameraErrors& errors) {
  return std::make_unique<ImperfectCamera>(std::move(inner), errors);
}

}  // namespace colift::sim_hal
