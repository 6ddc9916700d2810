// The last gate in the KRC's mode T1.
#include "hal/guards/t1_profile.hpp"

#include "guarded_arm_rig.hpp"

using namespace guards;

TEST_CASE("in T1 no joint is commanded faster than 0.24 rad/s, and the refusal says so", "[guard]") {
  Rig rig(in_t1({}));
  rig.run_up_to(0.239);
  JointVector q = rig.state.q_rad;
  q[0] += 0.25 * kPeriod_s;
  REQUIRE(rig.cycle());
  const auto refused = rig.send(q);
  REQUIRE_FALSE(refused);
  CHECK(refused.error().code == ErrorCode::LimitExceeded);
  CHECK_THAT(refused.error().detail, Catch::Contains("A1 would move with 0.250 rad/s (limit 0.240)"));
  rig.check_judge();
  Rig full;
  full.run_up_to(0.5);
  full.check_judge();
}

TEST_CASE("a joint at T1's speed brakes as hard as in any mode", "[guard]") {
  Rig rig(in_t1({}));
  rig.run_up_to(0.239);
  const double before = rig.wire->dq.cwiseAbs().maxCoeff();
  CHECK(before == Approx(0.239));
  for (int i = 0; i < 5; ++i) (void)rig.cycle();  // nobody answers
  CHECK(rig.wire->dq.cwiseAbs().maxCoeff() == 0.0);
  rig.check_judge();
}

TEST_CASE("what is set slower than T1 stays so", "[guard]") {
  GuardConfig slow;
  slow.max_velocity_rad_s = 0.1;
  CHECK(in_t1(slow).max_velocity_rad_s == 0.1);
}
