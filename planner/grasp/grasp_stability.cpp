#include "planner/grasp/grasp_stability.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

namespace colift::planner {

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
// Search for the first factor of a load that slips: bounds and steps, then halvings, which leave 3e-8 of a
// step. A margin above the largest factor counts as infinite.
constexpr double kMinFactor = 0.01, kLargestFactor = 100.0, kStep = 1.25;
constexpr int kHalvings = 25;

/// The fingers of one side and of the other, and what presses between them.
struct Grip {
  std::array<int, 2> fingers{};  // at -Hy, at +Hy
  std::array<double, 2> aside_m{};
  double squeeze_n = 0.0, width_m = 0.0, friction = 0.0;
  double patch_m = 0.0;  // lever of a patch's own friction
  double half_pad_m = 0.0, half_height_m = 0.0;
  double behind_rad = 0.0;  // pads beyond the middle of a cylinder
  bool round = false;

  [[nodiscard]] double roll_lever() const { return aside_m[0] + aside_m[1] + 2.0 * half_pad_m; }
  [[nodiscard]] double rub_lever(std::size_t side) const { return std::hypot(aside_m[side], patch_m); }
};

Grip grip_of(const GraspCandidate& candidate, const HandModel& hand) {
  Grip g;
  for (const HandFinger& finger : hand.fingers) {
    const std::size_t side = finger.side < 0 ? 0 : 1;
    ++g.fingers[side];
    g.aside_m[side] += std::abs(finger.x_m);
  }
  for (std::size_t side = 0; side < 2; ++side) g.aside_m[side] /= std::max(1, g.fingers[side]);
  g.squeeze_n = hand.finger_force_n * std::max(g.fingers[0], g.fingers[1]);
  g.width_m = candidate.width;
  g.friction = hand.friction;
  g.patch_m = 2.0 / 3.0 * std::sqrt(hand.pad_width_m * hand.pad_height_m / std::numbers::pi);
  g.half_pad_m = 0.5 * hand.pad_width_m;
  g.round = candidate.kind == GraspKind::Wrap;
  if (!g.round) {
    g.half_height_m = 0.5 * hand.pad_height_m;
    return g;
  }
  const double radius = 0.5 * candidate.width;
  const double height = contact_at_width(hand, candidate.width).height_m;
  g.behind_rad = std::asin(std::clamp((height - hand.gap(candidate) - radius) / radius, -1.0, 1.0));
  return g;
}

// outward force per newton of normal force
double hook(const Grip& g) {
  return std::max(0.0, g.friction * std::cos(g.behind_rad) + std::sin(g.behind_rad));
}

// what friction has to hold of a force along Hz
double rubbed_z(const Grip& g, double f_z) {
  if (f_z <= 0.0 || g.behind_rad == 0.0) return std::abs(f_z);
  if (g.behind_rad > 0.0) return 0.0;  // locked fingers stand in the way
  return hook(g) > 0.0 ? f_z * g.friction / hook(g) : kInfinity;
}

double over(double value, double strength) {
  if (value == 0.0) return 0.0;
  return strength > 0.0 ? std::abs(value) / strength : kInfinity;
}

// part of the friction that a load uses up; above 1 something slides
double friction_used(const Grip& g, const Vec3& f, const Vec3& t) {
  const std::size_t bears = f.y() < 0.0 ? 0 : 1, other = 1 - bears;
  const double n = g.fingers[0] + g.fingers[1];
  std::array<double, 2> normal{};
  normal[bears] = g.squeeze_n + std::abs(f.y()) * g.fingers[bears] / n;
  normal[other] = g.squeeze_n - std::abs(f.y()) * g.fingers[other] / n;
  if (normal[other] < 0.0) normal[other] = 0.0, normal[bears] = std::abs(f.y());

  const double both = normal[0] + normal[1];
  const double uneven_m = 0.5 * g.width_m * (normal[1] - normal[0]) / both;
  double shift_x = 0.0, twist = 0.0;
  for (std::size_t side = 0; side < 2; ++side) {
    shift_x += normal[side] * g.half_height_m;
    twist += g.friction * normal[side] * g.rub_lever(side);
  }
  const double f_z = rubbed_z(g, f.z());
  const double couple_z = over(std::max(0.0, std::abs(t.x() - uneven_m * f.z()) - shift_x), g.width_m);
  const double turned = over(t.y(), twist);
  double used = 0.0;
  for (std::size_t side = 0; side < 2; ++side) {
    const double part = normal[side] / both;
    const double rubs = std::hypot(part * std::abs(f.x()), part * f_z + couple_z);
    used = std::max(used, std::hypot(over(rubs, g.friction * normal[side]), turned));
  }
  return used;
}

}  // namespace

GraspStrength grasp_strength(const GraspCandidate& candidate, const HandModel& hand) {
  const Grip g = grip_of(candidate, hand);
  const double N = g.squeeze_n, mu = g.friction;
  GraspStrength s;
  const double height = contact_at_width(hand, candidate.width).height_m;
  s.center = candidate.position + std::max(0.0, height - hand.gap(candidate)) * candidate.approach;
  s.squeeze_n = N;
  s.bear_minus_n = hand.finger_hold_n * g.fingers[0];
  s.bear_plus_n = hand.finger_hold_n * g.fingers[1];
  s.shear_n = 2.0 * mu * N;
  s.pull_n = g.behind_rad > 0.0 ? (s.bear_minus_n + s.bear_plus_n) * hook(g) : 2.0 * N * hook(g);
  s.twist_nm = mu * N * (g.rub_lever(0) + g.rub_lever(1));
  s.pitch_nm = 2.0 * N * g.half_height_m + mu * N * g.width_m;
  s.roll_nm = N * g.roll_lever();
  return s;
}

StabilityMargin stability_margins(const GraspCandidate& candidate, const HandModel& hand,
                                  const hal::Wrench& load) {
  const Grip g = grip_of(candidate, hand);
  const GraspStrength s = grasp_strength(candidate, hand);
  const Eigen::Matrix3d R_HW = hand_pose(candidate, hand).linear().transpose();
  const Vec3 f = R_HW * load.force;
  Vec3 t = R_HW * load.torque;
  if (g.round) t += Vec3(0.0, 0.0, candidate.depth_m - 0.5 * g.width_m).cross(f);

  const std::size_t side = f.y() < 0.0 ? 0 : 1;
  const double turning_n = std::abs(t.z()) / g.roll_lever();
  double bears = over(std::abs(f.y()) / g.fingers[side] + turning_n, hand.finger_hold_n);
  if (g.behind_rad > 0.0 && f.z() > 0.0) bears = std::max(bears, over(f.z(), s.pull_n));
  StabilityMargin margin{kInfinity, bears > 0.0 ? 1.0 / bears : kInfinity};

  // pads that bear rub more, so the use of friction does not grow with the load alone: the first crossing
  double low = 0.0, high = kMinFactor;
  while (high < kLargestFactor && friction_used(g, high * f, high * t) <= 1.0) low = high, high *= kStep;
  if (high >= kLargestFactor) return margin;
  for (int i = 0; i < kHalvings; ++i) {
    const double middle = 0.5 * (low + high);
    (friction_used(g, middle * f, middle * t) <= 1.0 ? low : high) = middle;
  }
  margin.slip = low;
  return margin;
}

double stability_margin(const GraspCandidate& candidate, const HandModel& hand, const hal::Wrench& load) {
  return stability_margins(candidate, hand, load).least();
}

hal::Wrench load_on_robot(const AgentWrenches& decided) {
  return {-decided.robot.force, -decided.robot.torque - decided.partner.torque};
}

double fingertip_force(const HandModel& hand, double torque_nm) {
  return torque_nm / hand.finger.outer_length_m;
}

hal::Wrench nominal_load(const GraspCandidate& candidate, const Vec3& up, const Vec3& cog,
                         const StabilityConfig& config) {
  hal::Wrench load;
  load.force = -config.load_n * up;
  Vec3 line = cog - candidate.position;
  line -= up * up.dot(line);
  if (line.norm() > 1e-6) load.torque = config.load_n * config.cog_lever_m * line.normalized();
  return load;
}

}  // namespace colift::planner
