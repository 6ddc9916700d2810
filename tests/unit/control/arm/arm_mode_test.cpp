// The KRC's mode T1 as one setting: gate, planned ways and lift keep to it.
#include "control/config/arm_mode.hpp"

#include <catch2/catch.hpp>

#include "hal/guards/t1_profile.hpp"

using namespace colift;
using namespace colift::control;

TEST_CASE("without a mode nothing changes") {
  Config config = run_defaults();
  const Config same = for_arm_mode(config);
  CHECK(same.guard_arm.max_velocity_rad_s == config.guard_arm.max_velocity_rad_s);
  CHECK(same.motion.max_joint_rad_s == config.motion.max_joint_rad_s);
  CHECK(same.task.lift_s == config.task.lift_s);
}

TEST_CASE("in T1 ways are planned a little slower than the gate lets pass") {
  Config config = run_defaults();
  config.arm_mode = "t1";
  config.task.lift_height_m = 0.3;
  const Config slow = for_arm_mode(config);
  CHECK(slow.guard_arm.max_velocity_rad_s == hal::kT1Velocity_rad_s);
  CHECK(slow.motion.max_joint_rad_s < slow.guard_arm.max_velocity_rad_s);
  CHECK(slow.motion.transit_speed_m_s < 0.25);
  CHECK(slow.motion.acceleration_rad_s2 == hal::kT1Acceleration_rad_s2);
  // the top speed of the lift's profile
  CHECK(1.875 * slow.task.lift_height_m / slow.task.lift_s <= hal::kT1Palm_m_s * (1.0 + 1e-9));
}

TEST_CASE("what is slower than T1 stays as it is") {
  Config config;
  config.arm_mode = "t1";
  config.motion.max_joint_rad_s = 0.02;
  config.motion.transit_speed_m_s = 0.05;
  config.task.lift_s = 20.0;
  const Config slow = for_arm_mode(config);
  CHECK(slow.motion.max_joint_rad_s == 0.02);
  CHECK(slow.motion.transit_speed_m_s == 0.05);
  CHECK(slow.task.lift_s == 20.0);
}
