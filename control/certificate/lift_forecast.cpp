#include "control/certificate/lift_forecast.hpp"

#include <algorithm>
#include <cmath>

#include "hal/types/units.hpp"
#include "planner/grasp/grasp_stability.hpp"
#include "planner/grasp/share_choice.hpp"

namespace colift::control {
namespace {

using hal::Vec3;

constexpr double kStep_m = 1e-3;  // of the differences that make a gradient

// of the lever rule at these places
double lever_sigma(const planner::UncertainScene& s, const Vec3& robot) {
  const auto share = [&](const Vec3& cog, const Vec3& partner) {
    return planner::lever_share(cog, partner, robot, s.up).value_or(0.0);
  };
  Vec3 by_cog, by_partner;
  for (int k = 0; k < 3; ++k) {
    const Vec3 step = kStep_m * Vec3::Unit(k);
    by_cog[k] = (share(s.cog + step, s.partner) - share(s.cog - step, s.partner)) / (2.0 * kStep_m);
    by_partner[k] = (share(s.cog, s.partner + step) - share(s.cog, s.partner - step)) / (2.0 * kStep_m);
  }
  const double variance =
      by_cog.dot(s.cog_covariance * by_cog) + by_partner.dot(s.partner_covariance * by_partner);
  return std::sqrt(std::max(0.0, variance));
}

Vec3 level(const Vec3& v, const Vec3& up) {
  return v - v.dot(up) * up;
}

// Of the centre of gravity beside the vertical plane through both hands, and how well it is known.
double lever_m(const planner::UncertainScene& s, const Vec3& robot) {
  const Vec3 line = level(robot - s.partner, s.up);
  if (!(line.squaredNorm() > 0.0)) return 0.0;
  const Vec3 normal = s.up.cross(line.normalized());
  const double lever = normal.dot(s.cog - s.partner);
  // the partner's end of the plane moves as far as the centre of gravity lies nearer to him
  const double toward = std::clamp(line.dot(robot - s.cog) / line.squaredNorm(), 0.0, 1.0);
  const double variance =
      normal.dot(s.cog_covariance * normal) + toward * toward * normal.dot(s.partner_covariance * normal);
  return std::sqrt(lever * lever + std::max(0.0, variance));
}

}  // namespace

LiftForecast forecast_lift(const planner::UncertainScene& scene, const planner::GraspCandidate& grasp,
                           double share, const planner::HandModel& hand,
                           const planner::DecisionConfig& config, std::optional<double> mass_kg) {
  LiftForecast f;
  f.share = share;
  f.mass_known = mass_kg.has_value();
  f.weight_n = hal::kGravity_m_s2 * mass_kg.value_or(config.usual_mass_kg);
  const Vec3 robot = planner::load_point(grasp);
  f.span_m = level(robot - scene.partner, scene.up).norm();
  // of hands that resist a tilt: their torque over the weight's between them
  const double grip_sigma = f.span_m > 0.0 ? config.grip_torque_nm / (f.weight_n * f.span_m) : 0.0;
  f.share_sigma = std::hypot(lever_sigma(scene, robot), grip_sigma);
  f.turning_nm = f.weight_n * lever_m(scene, robot);
  const hal::Wrench load{-std::clamp(share, 0.0, 1.0) * f.weight_n * scene.up, Vec3::Zero()};
  const double margin = planner::stability_margins(grasp, hand, load).slip;
  f.load_over_hold = margin > 0.0 ? 1.0 / margin : 1e3;
  return f;
}

}  // namespace colift::control
