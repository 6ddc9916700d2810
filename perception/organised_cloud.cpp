#include "perception/organised_cloud.hpp"

#include "hal/types/avx2.hpp"

namespace colift::perception {
namespace {

// to = depth (along x + base) + origin. A missing depth is NaN and stays NaN through the arithmetic.
COLIFT_ALSO_AVX2 void place(const float* __restrict depth, const float* __restrict x, std::size_t n,
                            float along, float base, float origin, float* __restrict to) {
  for (std::size_t u = 0; u < n; ++u) to[u] = depth[u] * (along * x[u] + base) + origin;
}

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

  void points(int v, const float* depth, float* px, float* py, float* pz) const {
    const float y = static_cast<float>((v - k_.cy) / k_.fy);
    const Eigen::Vector3f base = R_.col(1) * y + R_.col(2);
    float* const to[3] = {px, py, pz};
    for (Eigen::Index i = 0; i < 3; ++i) place(depth, x_.data(), x_.size(), R_(i, 0), base[i], t_[i], to[i]);
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
