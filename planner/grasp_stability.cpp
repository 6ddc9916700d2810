#include "planner/grasp_stability.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace colift::planner {

GraspStrength grasp_strength(const GraspCandidate& candidate, const HandModel& hand) {
  int minus = 0, plus = 0;
  double a_minus = 0.0, a_plus = 0.0;
  for (const HandFinger& finger : hand.fingers) {
    (finger.side < 0 ? minus : plus)++;
    (finger.side < 0 ? a_minus : a_plus) += std::abs(finger.x_m);
  }
  a_minus /= std::max(1, minus);
  a_plus /= std::max(1, plus);

  const PadContact contact = contact_at_width(hand, candidate.width);
  const double gap = hand.gap(candidate), mu = hand.friction;
  const double N = hand.finger_force_n * std::min(minus, plus);
  const double b = hand.pad_width_m, h = hand.pad_height_m;
  const double r = 2.0 / 3.0 * std::sqrt(b * h / std::numbers::pi);

  double alpha = 0.0;
  if (candidate.kind == GraspKind::Wrap) {
    const double radius = 0.5 * candidate.width;
    alpha = std::asin(std::clamp((contact.height_m - gap - radius) / radius, -1.0, 1.0));
  }

  GraspStrength s;
  s.center = candidate.position + std::max(0.0, contact.height_m - gap) * candidate.approach;
  s.squeeze_n = N;
  s.bear_minus_n = hand.finger_hold_n * minus;
  s.bear_plus_n = hand.finger_hold_n * plus;
  s.shear_n = 2.0 * mu * N;
  s.pull_n = std::max(0.0, 2.0 * N * (mu * std::cos(alpha) + std::sin(alpha)));
  s.twist_nm = mu * N * (std::hypot(a_minus, r) + std::hypot(a_plus, r));
  s.pitch_nm = N * h + mu * N * candidate.width;
  s.roll_nm = N * (a_minus + a_plus + b);
  return s;
}

double stability_margin(const GraspCandidate& candidate, const HandModel& hand, const hal::Wrench& load) {
  const GraspStrength s = grasp_strength(candidate, hand);
  const Eigen::Matrix3d R_HW = hand_pose(candidate, hand).linear().transpose();
  const Vec3 f = R_HW * load.force;
  const Vec3 t = R_HW * load.torque;

  const auto part = [](double value, double strength) {
    if (value == 0.0) return 0.0;
    return strength > 0.0 ? std::abs(value) / strength : std::numeric_limits<double>::infinity();
  };
  const double bear = part(f.y(), f.y() < 0.0 ? s.bear_minus_n : s.bear_plus_n);
  const double terms[] = {part(f.x(), s.shear_n), part(f.z(), f.z() > 0.0 ? s.pull_n : s.shear_n),
                          part(t.y(), s.twist_nm), part(t.x(), s.pitch_nm), part(t.z(), s.roll_nm)};
  double squares = 0.0;
  for (const double term : terms) squares += term * term;
  const double used = std::max(bear, std::sqrt(squares));
  return used > 0.0 ? 1.0 / used : std::numeric_limits<double>::infinity();
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
