#pragma once

#include <span>
#include <string>

#include "hal/types/time.hpp"
#include "planner/motion/collision/collision_scene.hpp"
#include "planner/motion/free_space.hpp"
#include "planner/motion/motion_planner.hpp"
#include "planner/motion/trajectory/joint_path.hpp"

namespace colift::planner {

/// Both checkers of one collision world.
struct Checkers {
  FastChecker fast;
  ExactChecker exact;
};

/// What a free way is looked for with. References have to outlive the call.
struct TransitTools {
  const hal::RobotModel& model;
  const PlannerConfig& config;
  const MotionLimits& limits;
  Checkers& checkers;
  const hal::Clock* clock = nullptr;  ///< For the times only; may be null.
};

/// A way that is free by both checkers.
struct Transit {
  Trajectory trajectory;
  JointPath way_points;    ///< The corners before they were rounded.
  std::size_t goal = 0;    ///< Index of the goal that it ends in.
  double blend_rad = 0.0;  ///< By how much corners are rounded.
  std::string note;        ///< What is unusual about it.
};

/// Times of one plan (ms; 0 without a clock), added up over its attempts.
struct PlanTimes {
  double plan_ms = 0.0, shortcut_ms = 0.0, trajectory_ms = 0.0, exact_ms = 0.0;
};

/// From `start` to any of `goals`: straight if that is free, else RRT-Connect; then shortcuts, rounded
/// corners as far as these stay free, and the exact check of what will be driven. When that finds a contact,
/// the search is repeated at half of the step. Errors: NotFound; `where` names the step that failed.
[[nodiscard]] hal::Result<Transit> find_transit(TransitTools tools, const JointBox& box,
                                                const hal::JointVector& start,
                                                std::span<const hal::JointVector> goals, std::uint64_t seed,
                                                PlanTimes& times);

/// The first contact along a trajectory by the exact checker, as words; empty when there is none.
[[nodiscard]] std::string exact_contact(const Trajectory& trajectory, ExactChecker& exact, double step_rad);

/// Adds the time from its making to its end to `sum_ms`.
class Timed {
 public:
  Timed(const hal::Clock* clock, double& sum_ms)
      : clock_(clock), sum_ms_(sum_ms), start_(clock != nullptr ? clock->now() : hal::Timestamp{0}) {}
  ~Timed() {
    if (clock_ != nullptr) sum_ms_ += 1e3 * hal::seconds(clock_->now() - start_);
  }
  Timed(const Timed&) = delete;
  Timed& operator=(const Timed&) = delete;

 private:
  const hal::Clock* clock_;
  double& sum_ms_;
  hal::Timestamp start_;
};

}  // namespace colift::planner
