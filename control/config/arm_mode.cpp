#include "control/config/arm_mode.hpp"

#include <algorithm>

#include "hal/guards/t1_profile.hpp"

namespace colift::control {
namespace {

constexpr double kPlannedPart = 0.9;        // of T1's joint speed: the rest is for corrections
constexpr double kMinimumJerkPeak = 1.875;  // of its mean speed: 15/8, from the profile's derivative

}  // namespace

Config for_arm_mode(Config config) {
  if (config.arm_mode != "t1" && config.monitor.on) return config;  // nobody looks out: T1's speed
  config.guard_arm = hal::in_t1(config.guard_arm);
  planner::PlannerConfig& motion = config.motion;
  motion.transit_speed_m_s = std::min(motion.transit_speed_m_s, hal::kT1Palm_m_s);
  motion.approach_speed_m_s = std::min(motion.approach_speed_m_s, hal::kT1Palm_m_s);
  motion.max_joint_rad_s = std::min(motion.max_joint_rad_s, kPlannedPart * hal::kT1Velocity_rad_s);
  motion.acceleration_rad_s2 = std::min(motion.acceleration_rad_s2, hal::kT1Acceleration_rad_s2);
  motion.jerk_rad_s3 = std::min(motion.jerk_rad_s3, hal::kT1Jerk_rad_s3);
  config.task.lift_s =
      std::max(config.task.lift_s, kMinimumJerkPeak * config.task.lift_height_m / hal::kT1Palm_m_s);
  return config;
}

}  // namespace colift::control
