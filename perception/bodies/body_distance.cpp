#include "perception/bodies/body_distance.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace colift::perception {
namespace {

constexpr std::size_t kLanes = 8;

}  // namespace

void SphereSet::clear() {
  for (auto* a : {&x, &y, &z, &radius_m}) a->clear();
}

void SphereSet::add(const hal::Vec3& center_W, double sphere_radius_m) {
  x.push_back(static_cast<float>(center_W.x()));
  y.push_back(static_cast<float>(center_W.y()));
  z.push_back(static_cast<float>(center_W.z()));
  radius_m.push_back(static_cast<float>(sphere_radius_m));
}

bool nearest_approach(std::span<const BodyPoint> points, const SphereSet& spheres, double within_m,
                      Approach& out) {
  if (points.empty() || spheres.size() == 0) return false;
  // spheres in a box: a point far from the box is far from all of them
  Eigen::AlignedBox3f box;
  for (std::size_t i = 0; i < spheres.size(); ++i) {
    const Eigen::Vector3f c(spheres.x[i], spheres.y[i], spheres.z[i]);
    const Eigen::Vector3f r = Eigen::Vector3f::Constant(spheres.radius_m[i]);
    box.extend(Eigen::Vector3f(c - r));
    box.extend(Eigen::Vector3f(c + r));
  }
  auto least = static_cast<float>(within_m);
  bool found = false;
  const std::size_t n = spheres.size();
  for (const BodyPoint& point : points) {
    if (box.exteriorDistance(point.p_W) - point.hidden_m > least) continue;
    const float px = point.p_W.x(), py = point.p_W.y(), pz = point.p_W.z();
    const float ax = point.away.x(), ay = point.away.y(), az = point.away.z(), hidden = point.hidden_m;
    // squared distance of the centre from the segment, without a root: only spheres that may be nearer get
    // one
    for (std::size_t i = 0; i < n; i += kLanes) {
      const std::size_t m = std::min(kLanes, n - i);
      std::array<float, kLanes> squared;
      for (std::size_t l = 0; l < m; ++l) {
        const float dx = spheres.x[i + l] - px, dy = spheres.y[i + l] - py, dz = spheres.z[i + l] - pz;
        const float along = dx * ax + dy * ay + dz * az;
        float t = along < hidden ? along : hidden;
        t = t > 0.0F ? t : 0.0F;
        squared[l] = dx * dx + dy * dy + dz * dz + t * (t - 2.0F * along);
      }
      for (std::size_t l = 0; l < m; ++l) {
        const float reach = least + spheres.radius_m[i + l];
        if (!(reach > 0.0F && squared[l] < reach * reach)) continue;
        least = std::sqrt(std::max(0.0F, squared[l])) - spheres.radius_m[i + l];
        out = {static_cast<double>(least), point.p_W.cast<double>(), i + l};
        found = true;
      }
    }
  }
  return found;
}

}  // namespace colift::perception
