// The paths of a recovery: straight back from the object, and home.
#include <algorithm>
#include <memory>
#include <utility>
#include <vector>

#include "control/recovery/recovery.hpp"
#include "hal/types/units.hpp"
#include "planner/motion/collision/collision_scene.hpp"

namespace colift::control {
namespace {

using namespace std::chrono_literals;

constexpr int kDrawBackPoints = 12;
constexpr double kLevelled = 0.5;  // sine of the largest angle below the horizontal that is not followed
constexpr double kLargestStep_rad = 0.2;  // between two of them

}  // namespace

planner::MotionLimits Recovery::limits() const {
  planner::MotionLimits limits = planner::limits_of(rig_.model, config_.motion);
  limits.velocity_rad_s *= config_.recovery.speed_scale;
  limits.velocity_rad_s =
      limits.velocity_rad_s.cwiseMin(config_.setpoints.below(config_.guard_arm).velocity_rad_s);
  return limits;
}

hal::Result<planner::Trajectory> Recovery::draw_back_path() const {
  std::vector<hal::JointVector> points{arm_.commanded()};
  hal::Vec3 back = -hal::hand_pose(rig_.model, points.front()).linear().col(2);
  // a hand that points up a little would be drawn into the ground on which the object was put
  if (back.z() < 0.0 && back.z() > -kLevelled) back = hal::Vec3(back.x(), back.y(), 0.0).normalized();
  const hal::Pose X_WF = planner::flange_pose(geometry_, points.front());
  for (int i = 1; i <= kDrawBackPoints; ++i) {
    hal::Pose X = X_WF;
    X.translation() += back * (config_.recovery.clear_m * i / kDrawBackPoints);
    const auto q = planner::follow_ik(geometry_, X, points.back(),
                                      hal::deg_to_rad(config_.task.limit_margin_deg), kLargestStep_rad);
    if (!q) break;  // as far as the arm reaches
    points.push_back(*q);
  }
  return planner::make_trajectory_along(points, limits());
}

std::optional<Recovery::Finding> Recovery::prepare_home() {
  PerceptionSession session(options_.method, config_, rig_, stopwatch_);
  const hal::JointVector start = arm_.commanded();
  std::string why;
  if (auto camera = robot_.camera->configure(); !camera)
    why = camera.error().text();
  else if (auto active = robot_.camera->activate(); !active)
    why = active.error().text();
  const hal::Timestamp until = now_ + hal::duration_of(config_.recovery.scene_timeout_s);
  const auto posture = [&] { return RobotPosture{arm_.view().state.q_rad, hal::posture_of(*hand_)}; };
  while (why.empty() && session.reference_frames() < config_.task.reference_frames && now_ < until) {
    auto lost = read_devices();
    if (!lost)
      if (auto frame = robot_.camera->next_frame(0ms)) session.add_reference(std::move(*frame), posture());
    arm_.end_cycle();
    if (lost) return lost;
  }
  planned_ = false;
  if (why.empty()) {
    auto seen = session.analyse_scene(posture());
    if (const auto& correction = session.camera_correction(); correction && correction->applied())
      hooks_->say(correction->reason);
    if (!seen) {
      why = seen.error().detail;
    } else if (const auto& ground = session.analysis().scene.ground; !ground) {
      why = session.analysis().reason;
    } else {
      planner::MotionPlanner planner(rig_.model, rig_.hand, config_.motion, options_.seed);
      planner.set_scene(std::make_shared<planner::CollisionScene>(planner::make_collision_scene(
                            session.map(), ground->plane, {}, config_.motion.scene)),
                        session.map(), hal::Vec3::UnitZ());
      if (auto found = planner.plan_to(start, options_.home_rad))
        planned_ = set_home(*found);
      else
        why = found.error().detail;
    }
  }
  if (planned_) return std::nullopt;
  hooks_->say("no collision-free path home: " + why);
  auto straight = planner::make_trajectory(std::vector{start, options_.home_rad}, limits(), 0.0);
  if (!straight) return Finding{Event::Blocked, straight.error().text()};
  home_ = std::move(*straight);
  return std::nullopt;
}

// the planner's own speed is that of a job
bool Recovery::set_home(const planner::Trajectory& planned) {
  constexpr double kStep_s = 0.02;
  std::vector<hal::JointVector> points;
  const double s = planned.duration_s();
  const int count = std::max(2, static_cast<int>(s / kStep_s));
  for (int i = 0; i <= count; ++i) points.push_back(planned.sample(s * i / count).q_rad);
  auto slow = planner::make_trajectory_along(points, limits(), s / config_.recovery.speed_scale);
  if (slow) home_ = std::move(*slow);
  return slow.has_value();
}

}  // namespace colift::control
