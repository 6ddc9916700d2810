#include "planner/motion/motion_planner.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "hal/types/units.hpp"
#include "planner/motion/reach.hpp"
#include "planner/motion/trajectory/timing.hpp"
#include "planner/motion/transit.hpp"

namespace colift::planner {
namespace {

using hal::ErrorCode;
using hal::JointVector;

hal::HandPosture open_hand(const HandModel& hand) {
  return hal::coupled_posture(hal::deg_to_rad(hand.finger.open_deg));
}

}  // namespace

MotionLimits limits_of(const hal::RobotModel& model, const PlannerConfig& config) {
  MotionLimits limits;
  limits.velocity_rad_s =
      (config.velocity_fraction * model.velocity_rad_s()).cwiseMin(config.max_joint_rad_s);
  limits.acceleration_rad_s2 = JointVector::Constant(config.acceleration_rad_s2);
  limits.jerk_rad_s3 = JointVector::Constant(config.jerk_rad_s3);
  return limits;
}

struct MotionPlanner::Impl {
  Impl(const hal::RobotModel& robot, const HandModel& hand_model, const PlannerConfig& settings,
       std::uint64_t first_seed, const hal::Clock* stop_watch)
      : model(robot),
        hand(hand_model),
        config(settings),
        seed(first_seed),
        clock(stop_watch),
        arm(arm_geometry(model)),
        spheres(cover_with_spheres(model, config.search.sphere_excess_m)),
        limits(limits_of(model, config)) {
    const JointVector margin = JointVector::Constant(config.limit_margin_deg * hal::kRadPerDeg);
    box = {model.lower_rad() + margin, model.upper_rad() - margin};
  }

  hal::RobotModel model;
  HandModel hand;
  PlannerConfig config;
  std::uint64_t seed;
  const hal::Clock* clock;
  hal::Result<ArmGeometry> arm;
  SphereModel spheres;
  MotionLimits limits;
  JointBox box;

  std::shared_ptr<const CollisionScene> scene;
  hal::Vec3 up = hal::Vec3::UnitZ();
  std::unique_ptr<Checkers> checkers;
  std::unique_ptr<GraspReach> grasp_reach;

  [[nodiscard]] std::vector<GraspPosture> postures(const GraspCandidate& grasp, double lift_m,
                                                   std::size_t most, ReachRefusal& why);
  [[nodiscard]] hal::Result<> usable(const JointVector& start_rad, const char* what) const;
  [[nodiscard]] hal::Result<Trajectory> approach(const GraspPosture& posture, PlanTimes& times);
  [[nodiscard]] TransitTools tools() { return {model, config, limits, *checkers, clock}; }
};

MotionPlanner::MotionPlanner(const hal::RobotModel& model, const HandModel& hand, const PlannerConfig& config,
                             std::uint64_t seed, const hal::Clock* clock)
    : impl_(std::make_unique<Impl>(model, hand, config, seed, clock)) {}
MotionPlanner::~MotionPlanner() = default;
MotionPlanner::MotionPlanner(MotionPlanner&&) noexcept = default;
MotionPlanner& MotionPlanner::operator=(MotionPlanner&&) noexcept = default;

void MotionPlanner::set_scene(std::shared_ptr<const CollisionScene> scene, const perception::WorldMap& map,
                              const hal::Vec3& up) {
  Impl& m = *impl_;
  m.grasp_reach.reset();
  m.scene = std::move(scene);
  m.up = up.normalized();
  m.checkers.reset(
      new Checkers{FastChecker(m.model, m.spheres, m.scene), ExactChecker(m.model, map, m.scene->ground)});
  m.checkers->fast.set_hand(open_hand(m.hand));
  m.checkers->exact.set_hand(open_hand(m.hand));
  if (m.arm) m.grasp_reach = std::make_unique<GraspReach>(m.model, *m.arm, m.config, m.checkers->fast);
}

std::vector<GraspPosture> MotionPlanner::Impl::postures(const GraspCandidate& grasp, double lift_m,
                                                        std::size_t most, ReachRefusal& why) {
  if (!arm) {
    why = {arm.error().detail, std::nullopt};
    return {};
  }
  if (!grasp_reach) {
    why = {"no collision world was given", std::nullopt};
    return {};
  }
  return grasp_reach->find({planner::hand_pose(grasp, hand), up, lift_m}, most, why);
}

tl::expected<Reach, std::string> MotionPlanner::reach(const GraspCandidate& grasp, double lift_m) {
  ReachRefusal why;
  const auto found = impl_->postures(grasp, lift_m, 1, why);
  if (found.empty()) return tl::unexpected(why.reason);
  return found.front().reach;
}

void MotionPlanner::judge(std::vector<GraspCandidate>& candidates, double lift_m) {
  for (GraspCandidate& candidate : candidates) {
    if (candidate.verdict != Verdict::Ok) continue;
    ReachRefusal why;
    if (!impl_->postures(candidate, lift_m, 1, why).empty()) continue;
    candidate.verdict = Verdict::Unreachable;
    candidate.reason = why.reason;
    candidate.miss_m = why.miss_m;
  }
}

hal::Result<> MotionPlanner::Impl::usable(const JointVector& q_rad, const char* what) const {
  if (!checkers) return hal::failure(ErrorCode::NotReady, "plan", "no collision world was given");
  for (int i = 0; i < hal::kArmJoints; ++i) {
    if (std::isfinite(q_rad[i])) continue;
    return hal::failure(ErrorCode::BadInput, fmt::format("plan.{}", what),
                        fmt::format("A{} is {}", i + 1, q_rad[i]));
  }
  const JointVector lower = model.lower_rad(), upper = model.upper_rad();
  for (int i = 0; i < hal::kArmJoints; ++i) {
    if (q_rad[i] >= lower[i] && q_rad[i] <= upper[i]) continue;
    return hal::failure(
        ErrorCode::NotFound, fmt::format("plan.{}", what),
        fmt::format("A{} is at {:.1f} deg, beyond its limits {:.0f} to {:.0f} deg", i + 1,
                    hal::rad_to_deg(q_rad[i]), hal::rad_to_deg(lower[i]), hal::rad_to_deg(upper[i])));
  }
  return {};
}

hal::Result<Trajectory> MotionPlanner::Impl::approach(const GraspPosture& posture, PlanTimes& times) {
  hal::Result<Trajectory> made;
  {
    const Timed timed(clock, times.trajectory_ms);
    made = make_slow_trajectory_along(model, posture.approach, limits, config.approach_speed_m_s);
    if (!made) return hal::failure(ErrorCode::NotFound, "approach", made.error().detail);
    checkers->fast.allow(Contacts::FingersOnTarget);
    const JointPath states = sampled(*made, config.exact_step_rad);
    for (const JointVector& q : states) {
      if (checkers->fast.is_free(q)) continue;
      return hal::failure(ErrorCode::NotFound, "approach", checkers->fast.what_touches(q).text());
    }
  }
  const Timed timed(clock, times.exact_ms);
  checkers->exact.allow(Contacts::FingersOnTarget);
  const std::string contact = exact_contact(*made, checkers->exact, config.exact_step_rad);
  if (!contact.empty()) {
    return hal::failure(ErrorCode::NotFound, "exact check", fmt::format("on the approach {}", contact));
  }
  return made;
}

hal::Result<MotionPlan> MotionPlanner::plan(const JointVector& start_rad, const GraspCandidate& grasp,
                                            double lift_m) {
  Impl& m = *impl_;
  if (auto ok = m.usable(start_rad, "start"); !ok) return tl::unexpected(ok.error());
  const std::size_t checks_before = m.checkers->fast.checks();
  PlanTimes times;
  MotionPlan plan;
  std::vector<GraspPosture> postures;
  ReachRefusal why;
  {
    const Timed timed(m.clock, times.plan_ms);
    postures = m.postures(grasp, lift_m, static_cast<std::size_t>(m.config.goals), why);
  }
  if (postures.empty()) return hal::failure(ErrorCode::NotFound, "plan.reach", why.reason);
  // near ones first, good ones a little farther away too
  std::stable_sort(postures.begin(), postures.end(), [&](const GraspPosture& a, const GraspPosture& b) {
    const auto cost_weight = [&](const GraspPosture& p) {
      return joint_distance(p.reach.pre_grasp_rad, start_rad) * (1.5 - p.reach.score);
    };
    return cost_weight(a) < cost_weight(b);
  });

  hal::Error last{ErrorCode::NotFound, "transit", {}};
  while (!postures.empty()) {
    std::vector<JointVector> goals;
    for (const GraspPosture& posture : postures) goals.push_back(posture.reach.pre_grasp_rad);
    auto transit = find_transit(m.tools(), m.box, start_rad, goals, m.seed, times);
    if (!transit) {
      if (last.detail.empty()) last = transit.error();
      break;
    }
    const GraspPosture& posture = postures[transit->goal];
    auto approach = m.approach(posture, times);
    if (!approach) {
      last = approach.error();
      postures.erase(postures.begin() + static_cast<std::ptrdiff_t>(transit->goal));
      continue;
    }
    plan.transit = std::move(transit->trajectory);
    plan.approach = *std::move(approach);
    plan.retreat = plan.approach.reversed();
    plan.home = plan.transit.reversed();
    plan.reach = posture.reach;
    plan.X_WH_grasp = planner::hand_pose(grasp, m.hand);
    plan.note = transit->note;
    plan.plan_ms = times.plan_ms;
    plan.shortcut_ms = times.shortcut_ms;
    plan.trajectory_ms = times.trajectory_ms;
    plan.exact_ms = times.exact_ms;
    plan.states_checked = m.checkers->fast.checks() - checks_before;
    return plan;
  }
  last.where = "plan." + last.where;
  return tl::unexpected(last);
}

hal::Result<Trajectory> MotionPlanner::plan_to(const JointVector& start_rad, const JointVector& goal_rad) {
  Impl& m = *impl_;
  if (auto ok = m.usable(start_rad, "start"); !ok) return tl::unexpected(ok.error());
  if (auto ok = m.usable(goal_rad, "goal"); !ok) return tl::unexpected(ok.error());
  PlanTimes times;
  auto transit =
      find_transit(m.tools(), m.box.with(goal_rad), start_rad, std::span(&goal_rad, 1), m.seed, times);
  if (!transit) {
    hal::Error error = transit.error();
    error.where = "plan." + error.where;
    return tl::unexpected(error);
  }
  return std::move(transit->trajectory);
}

}  // namespace colift::planner
