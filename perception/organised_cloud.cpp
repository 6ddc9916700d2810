#include "perception/organised_cloud.hpp"

namespace colift::perception {

OrganisedCloud deproject(const hal::DepthFrame& frame, const hal::Pose& X_WC) {
  OrganisedCloud cloud;
  cloud.intrinsics = frame.intrinsics;
  cloud.X_WC = X_WC;
  cloud.depth_m = frame.depth_m;
  const std::size_t n = frame.depth_m.size();
  cloud.x.resize(n);
  cloud.y.resize(n);
  cloud.z.resize(n);

  const Eigen::Matrix3f R = X_WC.linear().cast<float>();
  const Eigen::Vector3f t = X_WC.translation().cast<float>();
  const auto& k = frame.intrinsics;
  std::vector<float> ray_x(static_cast<std::size_t>(k.width));
  for (int u = 0; u < k.width; ++u) ray_x[static_cast<std::size_t>(u)] = static_cast<float>((u - k.cx) / k.fx);

  // a missing depth is NaN and stays NaN through the arithmetic: no branch in the loop
  for (int v = 0; v < k.height; ++v) {
    const float ray_y = static_cast<float>((v - k.cy) / k.fy);
    const float bx = R(0, 1) * ray_y + R(0, 2);
    const float by = R(1, 1) * ray_y + R(1, 2);
    const float bz = R(2, 1) * ray_y + R(2, 2);
    const std::size_t row = static_cast<std::size_t>(v) * static_cast<std::size_t>(k.width);
    const float* depth = cloud.depth_m.data() + row;
    float* px = cloud.x.data() + row;
    float* py = cloud.y.data() + row;
    float* pz = cloud.z.data() + row;
    for (std::size_t u = 0; u < ray_x.size(); ++u) {
      const float d = depth[u];
      px[u] = d * (R(0, 0) * ray_x[u] + bx) + t.x();
      py[u] = d * (R(1, 0) * ray_x[u] + by) + t.y();
      pz[u] = d * (R(2, 0) * ray_x[u] + bz) + t.z();
    }
  }
  return cloud;
}

}  // namespace colift::perception
