#include "tools/experiments/trials/box_in_line.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "hal/types/units.hpp"
#include "planner/grasp/grasp_decision.hpp"
#include "planner/hand/hand_model.hpp"
#include "planner/motion/motion_planner.hpp"
#include "sim_hal/scenario/random_scenario.hpp"
#include "tools/experiments/trials/layouts.hpp"

namespace colift::experiments {
namespace {

using hal::Vec3;
using sim_hal::Draws;
using sim_hal::Scenario;

constexpr double kEnd_m = 0.05;         // half a hand, and what a grasp keeps from a face's end
constexpr double kHandsApart_m = 0.32;  // half a palm, half the partner's hand, the distance kept from him
constexpr double kMinLever_m = 0.12;    // of the partner in a layout: on less, a cm is much of the load
constexpr double kNearest_m = 0.45, kFarthest_m = 0.66;  // of the place from the robot's axis
constexpr double kNearEnd_m = 0.35;                      // of the box: room for the arm at home
constexpr double kLift_m = 0.05;
constexpr double kSlack = 0.03;  // of the load: so near to the wanted share the best place has to come

/// Of the place from the centre of gravity, away from the partner (m).
double place_of(double partner_m, double share) {
  return partner_m * (1.0 - share) / share;
}

/// Of the wrist from the shoulder, with the hand as high over the place as it has to go (m).
double wrist_from_shoulder(const Scenario& box, double place_m) {
  const planner::DecisionConfig arm;
  const planner::PlannerConfig motion;
  const Vec3 place = sim_hal::object_pose(box.object) * Vec3(-place_m, 0.0, box.object.size[2]);
  const double above = planner::HandModel().palm_gap_m + arm.wrist_to_palm_m +
                       std::max(motion.pre_grasp_m, kLift_m + motion.lift_margin_m);
  return (place + above * Vec3::UnitZ() - arm.shoulder_m).norm();
}

/// What stands against a hand at a place.
std::optional<std::string> place_forbidden(const Scenario& box, double place_m) {
  const double end = 0.5 * box.object.size[0] - kEnd_m, apart = box.partner.grasp.x() + place_m;
  if (place_m > end + 1e-9)
    return fmt::format("its place is {:.0f} mm beyond where the box can be held", 1e3 * (place_m - end));
  if (apart < kHandsApart_m - 1e-9)
    return fmt::format("the hands would be {:.0f} mm apart, min {:.0f} mm", 1e3 * apart, 1e3 * kHandsApart_m);
  const double reach = planner::DecisionConfig().arm_reach_m, far = wrist_from_shoulder(box, place_m);
  if (far > reach) return fmt::format("its place is {:.0f} mm beyond the arm's reach", 1e3 * (far - reach));
  const Vec3 at = sim_hal::object_pose(box.object) * Vec3(-place_m, 0.0, 0.0);
  if (const double near = at.head<2>().norm(); near < kNearest_m - 1e-9)
    return fmt::format("its place is {:.0f} mm from the robot's axis, min {:.0f} mm", 1e3 * near,
                       1e3 * kNearest_m);
  return std::nullopt;
}

}  // namespace

std::optional<std::string> share_forbidden(const Scenario& box, double share) {
  constexpr double kStep_m = 0.005;
  const double partner = box.partner.grasp.x(), half = 0.5 * box.object.size[0];
  for (double place = 0.0; place <= half; place += kStep_m) {
    const double borne = partner / (partner + place);
    if (std::abs(borne - share) <= kSlack && !place_forbidden(box, place)) return std::nullopt;
  }
  if (auto why = place_forbidden(box, place_of(partner, share))) return why;
  return fmt::format("no place gives {:.0f} %", 100 * share);
}

Scenario box_in_line(int index, std::uint64_t seed, double share) {
  if (index == 0) return shipped_box();
  Scenario s = box_layout(index, seed);
  Draws draws(sim_hal::hash(seed, 7350, static_cast<std::uint64_t>(index)), 7350);
  const double half = 0.5 * s.object.size[0], lever = share / (1.0 - share);
  // the partner stands lever times as far from the centre of gravity as the robot, and not beyond the end
  const double most = std::min(half - kEnd_m, half / lever);
  const double least = std::min(most, std::max(kMinLever_m / lever, kHandsApart_m / (1.0 + lever)));
  const double place = lever > 1.0 ? most : draws.between(least, most);
  // one hand lifts a wide box at its end only; elsewhere it has to be as thin as a hand can pinch
  if (lever <= 1.0)
    s.object.size = {s.object.size[0], draws.between(0.038, 0.046), draws.between(0.16, 0.24)};
  s.partner.grasp = {lever * place, 0.0, s.object.size[2]};

  const double least_away = std::min(kFarthest_m, std::max(kNearest_m, kNearEnd_m + half - place));
  const double away = draws.between(least_away, kFarthest_m);
  const double bearing = std::atan2(s.object.xyz.y(), s.object.xyz.x());
  const double yaw = hal::deg_to_rad(s.object.yaw_deg);
  s.object.xyz = away * Vec3(std::cos(bearing), std::sin(bearing), 0.0) +
                 place * Vec3(std::cos(yaw), std::sin(yaw), 0.0);
  sim_hal::draw_camera(s, draws);
  return s;
}

}  // namespace colift::experiments
