#include "perception/organised_cloud.hpp"

namespace colift::perception {
namespace {

// The rays of an image in W, row by row.
class Rays {
 public:
  Rays(const hal::CameraIntrinsics& k, const hal::Pose& X_WC)
      : k_(k),
        R_(X_WC.linear().cast<float>()),
        t_(X_WC.translation().cast<float>()),
        x_(static_cast<std::size_t>(k.width)) {
    for (int u = 0; u < k.width; ++u) x_[static_cast<std::size_t>(u)] = static_cast<float>((u - k.cx) / k.fx);
  }

  [[nodiscard]] std::size_t width() const { return x_.size(); }

  // A missing depth is NaN and stays NaN through the arithmetic: no branch in the loop.
  void points(int v, const float* __restrict depth, float* __restrict px, float* __restrict py,
              float* __restrict pz) const {
    const float y = static_cast<float>((v - k_.cy) / k_.fy);
    const float bx = R_(0, 1) * y + R_(0, 2), by = R_(1, 1) * y + R_(1, 2), bz = R_(2, 1) * y + R_(2, 2);
    const float r00 = R_(0, 0), r10 = R_(1, 0), r20 = R_(2, 0), tx = t_.x(), ty = t_.y(), tz = t_.z();
    const float* x = x_.data();
    for (std::size_t u = 0; u < x_.size(); ++u) {
      const float d = depth[u];
      px[u] = d * (r00 * x[u] + bx) + tx;
      py[u] = d * (r10 * x[u] + by) + ty;
      pz[u] = d * (r20 * x[u] + bz) + tz;
    }
  }

 private:
  const hal::CameraIntrinsics& k_;
  Eigen::Matrix3f R_;
  Eigen::Vector3f t_;
  std::vector<float> x_;
};

}  // namespace

OrganisedCloud deproject(const hal::DepthFrame& frame, const hal::Pose& X_WC) {
  OrganisedCloud cloud;
  cloud.intrinsics = frame.intrinsics;
  cloud.X_WC = X_WC;
  cloud.depth_m = frame.depth_m;
  for (auto* points : {&cloud.x, &cloud.y, &cloud.z}) points->reserve(frame.depth_m.size());
  // rows are made in the cache and appended: fresh memory is touched once, by the copy
  const Rays rays(frame.intrinsics, X_WC);
  const std::size_t w = rays.width();
  std::vector<float> rows(3 * w);
  float *px = rows.data(), *py = px + w, *pz = py + w;
  for (int v = 0; v < frame.intrinsics.height; ++v) {
    rays.points(v, cloud.depth_m.data() + static_cast<std::size_t>(v) * w, px, py, pz);
    cloud.x.insert(cloud.x.end(), px, px + w);
    cloud.y.insert(cloud.y.end(), py, py + w);
    cloud.z.insert(cloud.z.end(), pz, pz + w);
  }
  return cloud;
}

void deproject(const hal::DepthFrame& frame, const hal::Pose& X_WC, OrganisedCloud& cloud) {
  cloud.intrinsics = frame.intrinsics;
  cloud.X_WC = X_WC;
  cloud.depth_m.assign(frame.depth_m.begin(), frame.depth_m.end());
  for (auto* points : {&cloud.x, &cloud.y, &cloud.z}) points->resize(frame.depth_m.size());
  const Rays rays(frame.intrinsics, X_WC);
  for (int v = 0; v < frame.intrinsics.height; ++v) {
    const std::size_t at = static_cast<std::size_t>(v) * rays.width();
    rays.points(v, &cloud.depth_m[at], &cloud.x[at], &cloud.y[at], &cloud.z[at]);
  }
}

}  // namespace colift::perception
