#include "sim_hal/scenario/random_scenario.hpp"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "sim_hal/mock/hash_random.hpp"

namespace colift::sim_hal {
namespace {

// puts the object so that its near end lies `near_m` from the robot's axis, in the direction `bearing`
void place(ScenarioObject& object, double half_length_m, double near_m, double bearing_rad, double yaw_rad) {
  const double away = near_m + half_length_m * std::cos(yaw_rad - bearing_rad);
  object.xyz = {away * std::cos(bearing_rad), away * std::sin(bearing_rad), 0.0};
  object.yaw_deg = yaw_rad * 180.0 / std::numbers::pi;
}

}  // namespace

Scenario random_scenario(RandomKind kind, std::uint64_t seed) {
  const bool table = kind == RandomKind::Table;
  Draws draws(seed, table ? 7100 : 7200);
  Scenario s;
  s.name = fmt::format("random {} {}", table ? "table" : "box", seed);
  s.object.kind = table ? "table" : "box";
  const double bearing = draws.between(-0.25, 0.25), yaw = bearing + draws.between(-0.35, 0.35);
  s.object.friction = draws.between(0.5, 0.9);
  if (table) {
    const double length = draws.between(0.60, 0.95), width = draws.between(0.45, 0.75);
    s.object.size = {length, width, draws.between(0.40, 0.55)};
    s.object.mass = draws.between(2.0, 6.0);
    place(s.object, 0.5 * length, draws.between(0.60, 0.75), bearing, yaw);
    s.partner.grasp = {0.5 * length, draws.between(-0.25, 0.25) * width, s.object.size[2] - 0.0125};
  } else {
    const double length = draws.between(0.65, 1.0), width = draws.between(0.09, 0.15);
    s.object.size = {length, width, draws.between(0.16, 0.32)};
    s.object.mass = draws.between(1.5, 6.0);
    place(s.object, 0.5 * length, draws.between(0.45, 0.60), bearing, yaw);
    s.partner.grasp = {0.5 * length - draws.between(0.05, 0.12), 0.0, s.object.size[2]};
  }
  s.partner.kind = "compliant";
  s.partner.arrives_s = 2.5;
  // from the side, so that neither the arm nor the person hides the object
  const double side = draws.chance(0.5) ? -1.0 : 1.0;
  const Vec3 middle(s.object.xyz.x(), s.object.xyz.y(), 0.6 * s.object.size[2]);
  s.camera.xyz =
      middle + Vec3(draws.between(0.4, 1.1), side * draws.between(1.2, 1.6), draws.between(0.9, 1.3));
  s.camera.look_at = middle + Vec3(draws.between(-0.1, 0.05), draws.between(-0.05, 0.05), 0.0);
  s.camera.noise = "kinect";
  return s;
}

}  // namespace colift::sim_hal
