#pragma once

#include <span>
#include <string>
#include <vector>

#include "hal/config/range.hpp"
#include "hal/types/joints.hpp"
#include "hal/types/result.hpp"

namespace colift::planner {

/// Limits of a motion, per joint; defaults are the careful row of docs: half of the arm's velocity.
struct MotionLimits {
  hal::JointVector velocity_rad_s = hal::JointVector::Constant(0.95);
  hal::JointVector acceleration_rad_s2 = hal::JointVector::Constant(2.0);
  hal::JointVector jerk_rad_s3 = hal::JointVector::Constant(20.0);
};

/// Position, velocity and acceleration of all joints at one time.
struct JointSample {
  hal::JointVector q_rad = hal::JointVector::Zero(), dq_rad_s = hal::JointVector::Zero(),
                   ddq_rad_s2 = hal::JointVector::Zero();
};

/// A jerk-limited motion through joint space that starts and ends at rest, without acceleration. Position,
/// velocity and acceleration are continuous.
class Trajectory {
 public:
  Trajectory() = default;
  [[nodiscard]] double duration_s() const { return duration_s_; }
  /// Real-time safe; before 0 the start, after the end the goal, at rest.
  [[nodiscard]] JointSample sample(double t_s) const;
  [[nodiscard]] bool empty() const { return pieces_.empty(); }
  [[nodiscard]] const hal::JointVector& start() const { return start_; }
  [[nodiscard]] const hal::JointVector& goal() const { return goal_; }
  /// The same motion the other way round.
  [[nodiscard]] Trajectory reversed() const;

 private:
  friend class TrajectoryMaker;
  /// Cubic in time (constant jerk) for all joints.
  struct Piece {
    double start_s = 0.0;
    JointSample at;  ///< At its start.
    hal::JointVector jerk_rad_s3 = hal::JointVector::Zero();
  };
  [[nodiscard]] static JointSample after(const Piece& piece, double dt_s);

  double duration_s_ = 0.0;
  hal::JointVector start_ = hal::JointVector::Zero(), goal_ = hal::JointVector::Zero();
  std::vector<Piece> pieces_;
};

/// Time-parameterises a path of joint way points within velocity, acceleration and jerk limits, deviating
/// from the polyline at its corners by at most `blend_rad` in any joint (0: stops at each corner). A straight
/// path is followed in the shortest time. At corners the direction turns at constant speed in a ramp of
/// constant jerk, acceleration, jerk, so the limits hold exactly. Errors: BadInput (fewer than one way point,
/// not finite, limits not positive, blend negative).
[[nodiscard]] hal::Result<Trajectory> make_trajectory(std::span<const hal::JointVector> path,
                                                      const MotionLimits& limits, double blend_rad);

/// Time-parameterises a dense path (a straight line of the hand, a point per centimetre) without stopping:
/// one jerk-limited speed profile along a smooth curve through its points, then stretched in time until the
/// limits hold exactly. Takes `at_least_s` or longer. Errors: as make_trajectory().
[[nodiscard]] hal::Result<Trajectory> make_trajectory_along(std::span<const hal::JointVector> path,
                                                            const MotionLimits& limits,
                                                            double at_least_s = 0.0);

}  // namespace colift::planner
