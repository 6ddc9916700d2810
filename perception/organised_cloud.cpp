#include "perception/organised_cloud.hpp"

namespace colift::perception {

OrganisedCloud deproject(const hal::DepthFrame& frame, const hal::Pose& X_WC) {
  OrganisedCloud cloud;
  cloud.intrinsics = frame.intrinsics;
  cloud.X_WC = X_WC;
  cloud.depth_m = frame.depth_m;
  const std::size_t n = frame.depth_m.size();
  for (auto* points : {&cloud.x, &cloud.y, &cloud.z}) points->reserve(n);

  const Eigen::Matrix3f R = X_WC.linear().cast<float>();
  const Eigen::Vector3f t = X_WC.translation().cast<float>();
  const auto& k = frame.intrinsics;
  std::vector<float> ray_x(static_cast<std::size_t>(k.width));
  for (int u = 0; u < k.width; ++u)
    ray_x[static_cast<std::size_t>(u)] = static_cast<float>((u - k.cx) / k.fx);

  // Rows are made in the cache and appended: fresh memory is touched once, by the copy. A missing depth is
  // NaN and stays NaN through the arithmetic: no branch in the loop.
  const std::size_t w = ray_x.size();
  std::vector<float> rows(3 * w);
  float *px = rows.data(), *py = px + w, *pz = py + w;
  const float r00 = R(0, 0), r10 = R(1, 0), r20 = R(2, 0), tx = t.x(), ty = t.y(), tz = t.z();
  for (int v = 0; v < k.height; ++v) {
    const float ray_y = static_cast<float>((v - k.cy) / k.fy);
    const float bx = R(0, 1) * ray_y + R(0, 2);
    const float by = R(1, 1) * ray_y + R(1, 2);
    const float bz = R(2, 1) * ray_y + R(2, 2);
    const float* depth = cloud.depth_m.data() + static_cast<std::size_t>(v) * w;
    const float* rx = ray_x.data();
    for (std::size_t u = 0; u < w; ++u) {
      const float d = depth[u];
      px[u] = d * (r00 * rx[u] + bx) + tx;
      py[u] = d * (r10 * rx[u] + by) + ty;
      pz[u] = d * (r20 * rx[u] + bz) + tz;
    }
    cloud.x.insert(cloud.x.end(), px, px + w);
    cloud.y.insert(cloud.y.end(), py, py + w);
    cloud.z.insert(cloud.z.end(), pz, pz + w);
  }
  return cloud;
}

}  // namespace colift::perception
