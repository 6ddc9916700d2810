#include "control/test_lift/test_lift.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "hal/types/units.hpp"

namespace colift::control {
namespace {

constexpr double kSameHand_m = 0.05;  // nearer hands, less than a palm apart, hold no object between them

using Vec2 = Eigen::Vector2d;

bool is_finite(const CarriedObject& object) {
  return object.cog.allFinite() && object.cog_covariance.allFinite() &&
         std::all_of(object.feet.begin(), object.feet.end(),
                     [](const hal::Vec3& f) { return f.allFinite(); });
}

bool is_finite(const MeasuredLift& test) {
  return test.measured.force.allFinite() && test.measured.torque.allFinite() && test.palm.allFinite() &&
         test.partner.allFinite() && test.grasp.allFinite() && std::isfinite(test.drift_rad_s) &&
         test.X_WTnow_WTref.matrix().allFinite();
}

}  // namespace

Raise raise_on(const Hanging& now, const TestLiftConfig& config) {
  const double turn_deg = hal::rad_to_deg(std::abs(now.turn_rad));
  if (turn_deg > config.max_turn_deg || now.min_rise_m > config.clear_factor * config.belief.clear_m)
    return Raise::Enough;
  return turn_deg > config.slow_turn_deg ? Raise::Slowly : Raise::On;
}

hal::Result<TestLift> analyse_test_lift(const CarriedObject& object, std::span<const MeasuredLift> tests,
                                        const TestLiftConfig& config) {
  const auto bad = [](std::string why) {
    return hal::failure(hal::ErrorCode::BadInput, "test_lift", std::move(why));
  };
  if (tests.empty()) return bad("no test lift was made");
  for (const MeasuredLift& test : tests) {
    if (!is_finite(object) || !is_finite(test)) return bad("a number is not finite");
    const double span = (test.grasp - test.partner).head<2>().norm();
    if (span < kSameHand_m) return bad(fmt::format("the hands are {:.0f} mm apart", 1e3 * span));
  }
  const MeasuredLift& last = tests.back();
  const double load_n = -last.measured.force.z();
  if (load_n < config.min_load_n)
    return hal::failure(hal::ErrorCode::NotFound, "test_lift",
                        fmt::format("the robot carries {:.1f} N (min {:.1f} N): the object is on the ground",
                                    load_n, config.min_load_n));
  auto belief = weigh_cog(object, tests, config.belief);
  if (!belief) return tl::unexpected(belief.error());

  TestLift out;
  out.seen = hanging(object, last.partner, last.grasp, last.X_WTnow_WTref);
  out.stands = out.seen.min_rise_m < config.belief.clear_m;
  out.belief = std::move(*belief);
  out.mass_kg = out.belief.mass_kg();
  out.cog = object.cog;
  out.cog.head<2>() = out.belief.mean();
  const Vec2 line = (last.grasp - last.partner).head<2>().normalized();
  const Vec2 arm = (out.cog - last.partner).head<2>();
  out.lever_m = std::abs(arm.x() * line.y() - arm.y() * line.x());
  out.share = load_n / (out.mass_kg * hal::kGravity_m_s2);

  const std::string facts = fmt::format(
      "{:.1f} kg, centre of gravity {:.0f} mm from where its shape has it, {:.0f} mm beside the line "
      "between both hands",
      out.mass_kg, 1e3 * (out.cog - object.cog).norm(), 1e3 * out.lever_m);
  const double drift_deg_s = hal::rad_to_deg(std::abs(last.drift_rad_s));
  out.bearable = !out.stands && out.seen.tilt_rad <= hal::deg_to_rad(config.max_turn_deg) &&
                 drift_deg_s <= config.max_drift_deg_s;
  if (out.stands && out.seen.tilt_rad < hal::deg_to_rad(config.standing_turn_deg)) {
    out.next = TestLift::Next::Regrasp;
    out.reason = fmt::format("the object did not move: the hand slides on it at {:.0f} N", load_n);
  } else if (out.stands || out.seen.tilt_rad > hal::deg_to_rad(config.good_turn_deg)) {
    out.next = TestLift::Next::Regrasp;
    out.reason = fmt::format("turned by {:.1f} deg (limit {:.1f}){}: {}", hal::rad_to_deg(out.seen.tilt_rad),
                             config.good_turn_deg, out.stands ? " and stands on a foot" : "", facts);
  } else if (drift_deg_s > config.max_drift_deg_s) {
    out.next = TestLift::Next::Regrasp;
    out.reason = fmt::format("turns in the hand by {:.1f} deg in a second (limit {:.1f}): {}", drift_deg_s,
                             config.max_drift_deg_s, facts);
  } else if (std::abs(out.share - last.share_predicted) > config.max_share_error) {
    out.next = TestLift::Next::OtherShare;
    out.reason = fmt::format("{}; the robot carries {:.0f} % (predicted {:.0f} %)", facts, 100 * out.share,
                             100 * last.share_predicted);
  } else {
    out.reason = facts;
  }
  return out;
}

std::optional<NextGrip> next_grip(std::span<const planner::GraspCandidate> grasps, const hal::Vec3& partner,
                                  std::span<const MeasuredLift> tests, const CogBelief& belief,
                                  double wanted_share, const TestLiftConfig& config) {
  const Vec2 mean = belief.mean();
  std::vector<NextGrip> possible;
  double best = config.min_level_probability;
  for (std::size_t i = 0; i < grasps.size(); ++i) {
    using planner::Verdict;
    const planner::GraspCandidate& c = grasps[i];
    if (c.verdict != Verdict::Ok && c.verdict != Verdict::Chosen) continue;
    const hal::Vec3 grasp = planner::load_point(c);
    if ((grasp - partner).head<2>().norm() < kSameHand_m) continue;
    if (std::any_of(tests.begin(), tests.end(), [&](const MeasuredLift& t) {
          return (t.grasp - grasp).norm() < config.same_grip_m &&
                 (t.partner - partner).norm() < config.same_partner_m;
        }))
      continue;
    const double chance = chance_level(belief, partner, grasp, config.good_turn_deg * hal::kRadPerDeg,
                                       config.belief.grip_sigma);
    possible.push_back({i, chance, lever_share(mean, partner, grasp)});
    best = std::max(best, chance);
  }
  std::optional<NextGrip> next;
  const double least = std::max(config.min_level_probability, best - config.level_probability_tolerance);
  for (const NextGrip& grip : possible) {
    if (grip.chance < least) continue;
    if (!next || std::abs(grip.share - wanted_share) < std::abs(next->share - wanted_share)) next = grip;
  }
  return next;
}

}  // namespace colift::control
