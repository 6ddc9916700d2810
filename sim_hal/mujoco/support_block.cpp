#include "sim_hal/mujoco/support_block.hpp"

#include <algorithm>
#include <limits>

#include "hal/types/units.hpp"

namespace colift::sim_hal {
namespace {

constexpr double kSide_m = 0.06, kLowest_m = 0.02, kHighest_m = 2.0, kStep_m = 0.002;

bool inside(const ObjectParts& object, const Vec3& p_T) {
  return std::any_of(object.parts.begin(), object.parts.end(),
                     [&](const ObjectParts::Part& part) { return distance(part.shape, p_T) <= 0.0; });
}

/// Height of the lowest matter over a point of the floor (m in T); infinite when there is none.
double underside(const ObjectParts& object, double x, double y) {
  for (double z = 0.0; z < kHighest_m; z += kStep_m) {
    if (!inside(object, {x, y, z})) continue;
    double low = z - kStep_m, high = z;
    for (int i = 0; i < 30; ++i)
      (inside(object, {x, y, 0.5 * (low + high)}) ? high : low) = 0.5 * (low + high);
    return high;
  }
  return std::numeric_limits<double>::infinity();
}

}  // namespace

std::optional<SupportBlock> support_block(const Scenario& scenario, const ObjectParts& object) {
  const Vec3& grasp = scenario.partner.grasp;
  const Vec3 to_middle(object.cog_T.x() - grasp.x(), object.cog_T.y() - grasp.y(), 0.0);
  const Vec3 inwards = to_middle.norm() > 1e-6 ? Vec3(to_middle.normalized()) : Vec3(Vec3::UnitX());
  const double yaw = std::atan2(inwards.y(), inwards.x());
  const Vec3 across(-inwards.y(), inwards.x(), 0.0);
  for (double depth = 0.5 * kSide_m; depth < to_middle.norm(); depth += 0.5 * kSide_m) {
    const Vec3 middle = grasp + depth * inwards;
    double height = std::numeric_limits<double>::infinity();
    for (const double u : {-0.5, 0.0, 0.5}) {
      for (const double v : {-0.5, 0.0, 0.5}) {
        const Vec3 p = middle + kSide_m * (0.99 * u * inwards + 0.99 * v * across);
        height = std::min(height, underside(object, p.x(), p.y()));
      }
    }
    const Pose X_WT = object_pose(scenario.object);
    const double top_W = height + X_WT.translation().z();
    if (!(height > kLowest_m) || !(top_W < kHighest_m)) continue;
    SupportBlock block;
    block.size = {kSide_m, kSide_m, top_W};
    block.center_W = X_WT * middle;
    block.center_W.z() = 0.5 * top_W;
    block.yaw_rad = yaw + hal::deg_to_rad(scenario.object.yaw_deg);
    return block;
  }
  return std::nullopt;
}

}  // namespace colift::sim_hal
