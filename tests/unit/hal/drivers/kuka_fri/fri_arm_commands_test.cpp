// In command mode: what is commanded, repeated, refused, ramped and braked.
#include <cmath>

#include "fri_arm_rig.hpp"

namespace colift {

using namespace test;

TEST_CASE("in command mode the commands go out as they are, once each", "[fri][arm]") {
  FakeKrc krc;
  const auto arm = krc.arm();
  REQUIRE(arm->configure());
  REQUIRE(arm->activate());
  JointVector q = next(*arm).q_rad;
  REQUIRE(arm->command(hold_at(q)));
  for (int i = 0; i < 100; ++i) {
    const auto s = next(*arm);
    CHECK(s.may_command);
    hal::ImpedanceCommand c = hold_at(q);
    q[3] += 0.0005 * std::sin(i * 0.03);
    c.q_rad = q;
    c.stiffness_nm_rad.setConstant(650.0);
    c.damping_ratio.setConstant(0.5);
    REQUIRE(arm->command(c));
    CHECK_FALSE(arm->command(c));
  }
  next(*arm);
  const auto& last = krc.heard.back();
  CHECK(last.flags == 0x35);
  CHECK(static_cast<double>(last.q_rad[3]) == Approx(q[3]).margin(1e-6));
  CHECK(last.stiffness_nm_rad[6] == 650.0f);
  CHECK(last.damping[0] == 0.5f);
  CHECK(krc.twice == 0);
  CHECK(krc.flags_changed == 0);
  CHECK(krc.not_mirrored == 0);
}

TEST_CASE("a cycle without a command is answered with the last one", "[fri][arm]") {
  FakeKrc krc;
  const auto arm = krc.arm();
  REQUIRE(arm->configure());
  REQUIRE(arm->activate());
  JointVector q = next(*arm).q_rad;
  REQUIRE(arm->command(hold_at(q)));
  next(*arm);
  q[0] += 0.0001;
  REQUIRE(arm->command(hold_at(q)));
  const std::size_t before = krc.heard.size();
  for (int i = 0; i < 50; ++i) next(*arm);
  REQUIRE(krc.heard.size() > before + 40);
  for (std::size_t i = before + 1; i < krc.heard.size(); ++i)
    CHECK(krc.heard[i].q_rad == krc.heard[before + 1].q_rad);
  CHECK(static_cast<double>(krc.heard.back().q_rad[0]) == Approx(q[0]).margin(1e-6));
}

TEST_CASE("the first command is the measured pose, and an arm that hangs in its springs is not jerked there",
          "[fri][arm]") {
  FakeKrc krc;
  krc.sag_rad = {0.0f, 0.03f, 0.0f, -0.02f, 0, 0, 0};
  const auto arm = krc.arm();
  REQUIRE(arm->configure());
  REQUIRE(arm->activate());
  const JointVector q = next(*arm).q_rad;
  SECTION("another pose than the measured one is refused") {
    JointVector elsewhere = q;
    elsewhere[2] += 0.02;
    const auto refused = arm->command(hold_at(elsewhere));
    REQUIRE_FALSE(refused);
    CHECK(refused.error().code == ErrorCode::LimitExceeded);
    CHECK(arm->health().rejected > 0);
  }
  SECTION("the controller is led from its own pose to the measured one") {
    const float before = krc.followed()[1];
    REQUIRE(arm->command(hold_at(q)));
    for (int i = 0; i < 500; ++i) {
      next(*arm);
      REQUIRE(arm->command(hold_at(q)));
    }
    next(*arm);
    CHECK(static_cast<double>(krc.heard.back().q_rad[1]) == Approx(before + 0.03).margin(1e-5));
    CHECK(krc.worst_step_rad < 0.2 * 0.002 + 1e-6);
    CHECK(krc.worst_dv_rad_s < 2.5 * 0.002 + 3e-4);  // float rounding of a position, over one cycle
  }
}

TEST_CASE("superposed torque starts at zero and grows by its slope", "[fri][arm]") {
  FakeKrc krc;
  hal::FriConfig config = FakeKrc::quick();
  config.superposed_slope_nm_s = 100.0;
  const auto arm = krc.arm(config);
  REQUIRE(arm->configure());
  REQUIRE(arm->activate());
  const JointVector q = next(*arm).q_rad;
  hal::ImpedanceCommand c = hold_at(q);
  c.tau_superposed_nm[1] = 10.0;
  for (int i = 0; i < 120; ++i) {
    REQUIRE(arm->command(c));
    next(*arm);
  }
  float last = 0.0f;
  for (const auto& heard : krc.heard) {
    CHECK(heard.tau_nm[1] - last <= 0.2001f);
    CHECK(heard.tau_nm[0] == 0.0f);
    last = heard.tau_nm[1];
  }
  CHECK(last == 10.0f);
  CHECK(krc.torque_outside == 0);
}

TEST_CASE("commands out of range are refused one by one", "[fri][arm]") {
  FakeKrc krc;
  const auto arm = krc.arm();
  REQUIRE(arm->configure());
  REQUIRE(arm->activate());
  const JointVector q = next(*arm).q_rad;
  REQUIRE(arm->command(hold_at(q)));
  const std::vector<std::function<void(hal::ImpedanceCommand&)>> bad = {
      [](auto& c) { c.q_rad[0] = std::nan(""); },
      [](auto& c) { c.q_rad[3] = 2.2; },
      [](auto& c) { c.q_rad[0] += 0.01; },
      [](auto& c) { c.stiffness_nm_rad[5] = 2001; },
      [](auto& c) { c.stiffness_nm_rad[5] = -1; },
      [](auto& c) { c.damping_ratio[2] = 1.1; },
      [](auto& c) { c.tau_superposed_nm[6] = 39.0; },
      [](auto& c) { c.tau_superposed_nm[0] = 61.0; },
      [](auto& c) { c.damping_ratio[2] = std::nan(""); }};
  for (const auto& change : bad) {
    next(*arm);
    hal::ImpedanceCommand c = hold_at(q);
    change(c);
    const auto refused = arm->command(c);
    REQUIRE_FALSE(refused);
    CHECK(refused.error().code == ErrorCode::LimitExceeded);
    CHECK(refused.error().detail.size() <= 15);
    CHECK_FALSE(hal::words(arm->status().last_refused).empty());
    // the cycle is still open for a good one
    CHECK(arm->command(hold_at(q)));
  }
  CHECK(arm->status().refused == bad.size());
}

TEST_CASE("safety limits of the controller shrink the step that is taken", "[fri][arm]") {
  FakeKrc krc;
  krc.m.safety_limits = 0.1f;
  const auto arm = krc.arm();
  REQUIRE(arm->configure());
  REQUIRE(arm->activate());
  JointVector q = next(*arm).q_rad;
  REQUIRE(arm->command(hold_at(q)));
  next(*arm);
  q[0] += 0.001;  // 0.5 rad/s, a quarter of the joint's own limit
  CHECK_FALSE(arm->command(hold_at(q)));
}

TEST_CASE("a stopped arm brakes, stays in command mode and goes on only after activate()", "[fri][arm]") {
  FakeKrc krc;
  const auto arm = krc.arm();
  REQUIRE(arm->configure());
  REQUIRE(arm->activate());
  JointVector q = next(*arm).q_rad;
  double v = 0.0;
  for (int i = 0; i < 100; ++i) {
    REQUIRE(arm->command(hold_at(q)));
    v = std::min(0.5, v + 0.02);
    q[0] += v * 0.002;
    next(*arm);
  }
  krc.worst_dv_rad_s = 0.0;
  arm->stop();
  for (int i = 0; i < 100; ++i) {
    CHECK_FALSE(next(*arm).may_command);
    const auto refused = arm->command(hold_at(q));
    REQUIRE_FALSE(refused);
    CHECK(refused.error().code == ErrorCode::NotReady);
    CHECK(refused.error().detail == "stopped");
  }
  CHECK(krc.worst_dv_rad_s < 0.04);  // 15 rad/s^2, no jerk to a standstill
  CHECK(krc.m.state == hal::FriState::Command);
  const auto rest = krc.heard.back().q_rad;
  next(*arm);
  CHECK(krc.heard.back().q_rad == rest);
  REQUIRE(arm->activate());
  const auto s = next(*arm);
  CHECK(s.may_command);
  CHECK_FALSE(arm->command(hold_at(q + JointVector::Constant(0.05))));
  CHECK(arm->command(hold_at(s.q_rad)));
  CHECK(krc.twice == 0);
}

}  // namespace colift
