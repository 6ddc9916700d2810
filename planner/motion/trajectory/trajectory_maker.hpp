#pragma once

#include "planner/motion/trajectory/trajectory.hpp"

namespace colift::planner {

/// Builds a Trajectory piece by piece.
class TrajectoryMaker {
 public:
  explicit TrajectoryMaker(const hal::JointVector& start);

  /// Appends a piece of constant jerk that starts in the given state; nothing when it has no duration.
  void append(double duration_s, const JointSample& at, const hal::JointVector& jerk_rad_s3);
  /// State at the end of what is there.
  [[nodiscard]] JointSample end() const;

  /// By which factor time has to be stretched (> 1) or may be shortened until one limit is just met.
  [[nodiscard]] double stretch(const MotionLimits& limits) const;
  void scale_time(double factor);

  [[nodiscard]] Trajectory finish(const hal::JointVector& goal) &&;

 private:
  Trajectory made_;
};

/// BadInput when there is no way point, or one or a limit is not what it has to be.
[[nodiscard]] hal::Result<> check_path(std::span<const hal::JointVector> path, const MotionLimits& limits);

}  // namespace colift::planner
