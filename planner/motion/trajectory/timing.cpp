#include "planner/motion/trajectory/timing.hpp"

#include <algorithm>

#include "hal/robot_model/robot_model.hpp"

namespace colift::planner {
namespace {

/// Between samples the speed rises by no more than the limit of the acceleration allows.
constexpr double kSampleS = 0.01;

/// A trajectory does not scale exactly with its velocity limits: a few rounds, each a little more careful.
constexpr int kRounds = 6;

}  // namespace

double palm_speed_m_s(const hal::RobotModel& model, const Trajectory& trajectory) {
  double fastest = 0.0;
  for (double t = 0.0; t < trajectory.duration_s(); t += kSampleS) {
    const JointSample s = trajectory.sample(t);
    const Eigen::Matrix<double, 6, 1> twist = hal::jacobian(model, s.q_rad, hal::Vec3::Zero()) * s.dq_rad_s;
    fastest = std::max(fastest, twist.head<3>().norm());
  }
  return fastest;
}

hal::Result<Trajectory> make_slow_trajectory(const hal::RobotModel& model,
                                             std::span<const hal::JointVector> path,
                                             const MotionLimits& limits, double blend_rad, double speed_m_s) {
  MotionLimits slower = limits;
  hal::Result<Trajectory> made = make_trajectory(path, slower, blend_rad);
  for (int round = 0; made && round < kRounds; ++round) {
    const double fastest = palm_speed_m_s(model, *made);
    if (fastest <= speed_m_s) break;
    const double factor = 0.99 * speed_m_s / fastest;
    slower.velocity_rad_s *= factor;
    if (round >= 2) {
      // lower velocities alone did not do it: slow everything in time, which always does
      slower.acceleration_rad_s2 *= factor * factor;
      slower.jerk_rad_s3 *= factor * factor * factor;
    }
    made = make_trajectory(path, slower, blend_rad);
  }
  return made;
}

hal::Result<Trajectory> make_slow_trajectory_along(const hal::RobotModel& model,
                                                   std::span<const hal::JointVector> path,
                                                   const MotionLimits& limits, double speed_m_s) {
  hal::Result<Trajectory> made = make_trajectory_along(path, limits);
  for (int round = 0; made && round < kRounds; ++round) {
    const double fastest = palm_speed_m_s(model, *made);
    if (fastest <= speed_m_s) break;
    made = make_trajectory_along(path, limits, 1.01 * made->duration_s() * fastest / speed_m_s);
  }
  return made;
}

JointPath sampled(const Trajectory& trajectory, double step_rad) {
  JointPath out{trajectory.start()};
  hal::JointVector last = trajectory.start();
  for (double t = kSampleS; t < trajectory.duration_s(); t += kSampleS) {
    const hal::JointVector q = trajectory.sample(t).q_rad;
    // the step before the one that would be too far
    if (joint_distance(q, out.back()) > step_rad && last != out.back()) out.push_back(last);
    last = q;
  }
  out.push_back(trajectory.goal());
  return out;
}

}  // namespace colift::planner
