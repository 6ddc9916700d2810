#include "sim_hal/scenario/random_scenario.hpp"

#include <fmt/format.h>

#include <cmath>

#include "hal/types/units.hpp"
#include "sim_hal/synthetic/ray_caster.hpp"

namespace colift::sim_hal {
namespace {

// puts the object so that its near end lies `near_m` from the robot's axis, in the direction `bearing`
void place(ScenarioObject& object, double half_length_m, double near_m, double bearing_rad, double yaw_rad) {
  const double away = near_m + half_length_m * std::cos(yaw_rad - bearing_rad);
  object.xyz = {away * std::cos(bearing_rad), away * std::sin(bearing_rad), 0.0};
  object.yaw_deg = hal::rad_to_deg(yaw_rad);
}

// whether the camera sees all corners of the object and room for a hand at the grasp
bool in_view(const Scenario& s) {
  constexpr double kMargin_px = 15.0, kHand_px = 60.0;
  const hal::CameraIntrinsics k;
  const Pose X_CT = look_at(s.camera.xyz, s.camera.look_at).inverse() * object_pose(s.object);
  const auto inside = [&](const Vec3& p_T, double margin) {
    const Vec3 p = X_CT * p_T;
    const double u = k.fx * p.x() / p.z() + k.cx, v = k.fy * p.y() / p.z() + k.cy;
    return u > margin && v > margin && u < k.width - margin && v < k.height - margin;
  };
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3 p(corner & 1 ? 0.5 : -0.5, corner & 2 ? 0.5 : -0.5, corner & 4 ? 1.0 : 0.0);
    if (!inside(p.cwiseProduct(Vec3(s.object.size[0], s.object.size[1], s.object.size[2])), kMargin_px))
      return false;
  }
  return inside(s.partner.grasp, kHand_px);
}

}  // namespace

Scenario random_scenario(RandomKind kind, std::uint64_t seed) {
  const bool table = kind == RandomKind::Table;
  Draws draws(seed, table ? 7100 : 7200);
  Scenario s;
  s.name = fmt::format("random {} {}", table ? "table" : "box", seed);
  s.object.kind = table ? "table" : "box";
  const double bearing = draws.between(-0.25, 0.25), yaw = bearing + draws.between(-0.35, 0.35);
  s.object.friction = draws.between(0.6, 0.9);
  if (table) {
    const double length = draws.between(0.60, 0.95), width = draws.between(0.45, 0.75);
    s.object.size = {length, width, draws.between(0.40, 0.55)};
    s.object.mass = draws.between(2.0, 6.0);
    place(s.object, 0.5 * length, draws.between(0.68, 0.85), bearing, yaw);
    s.partner.grasp = {0.5 * length, draws.between(-0.25, 0.25) * width, s.object.size[2] - 0.0125};
  } else {
    const double length = draws.between(0.65, 1.0), width = draws.between(0.09, 0.15);
    s.object.size = {length, width, draws.between(0.16, 0.32)};
    s.object.mass = draws.between(1.5, 4.5);
    place(s.object, 0.5 * length, draws.between(0.45, 0.60), bearing, yaw);
    s.partner.grasp = {0.5 * length, draws.between(-0.3, 0.3) * width, s.object.size[2]};
  }
  s.partner.kind = "compliant";
  s.partner.arrives_s = 2.5;
  draw_camera(s, draws);
  return s;
}

void draw_camera(Scenario& s, Draws& draws, double least_m, double most_m) {
  const Vec3 middle(s.object.xyz.x(), s.object.xyz.y(), 0.6 * s.object.size[2]);
  constexpr int kAttempts = 50;
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    const double side = draws.chance(0.5) ? -1.0 : 1.0;
    s.camera.xyz = middle + Vec3(draws.between(least_m, most_m), side * draws.between(1.2, 1.6),
                                 draws.between(0.9, 1.3));
    s.camera.look_at = middle + Vec3(draws.between(-0.1, 0.05), draws.between(-0.05, 0.05), 0.0);
    if (in_view(s)) break;
  }
  s.camera.noise = "kinect";
}

}  // namespace colift::sim_hal
