// What can be wrong with what is measured, rows 46 and 47 of the fault table.

#include "moving_driver.hpp"

namespace colift {

using namespace test;

TEST_CASE("a joint that jumps is garbage: held, and not handed on (row 46)", "[fri][faults]") {
  Moving run;
  run.cycles(100);
  run.krc.worst_dv_rad_s = 0.0;
  run.krc.tamper = [](hal::FriMeasurement& m) {
    m.q_measured_rad[1] += 0.3f;
    return true;
  };
  const auto s = run.arm->wait_cycle();
  REQUIRE_FALSE(s);
  CHECK(s.error().code == ErrorCode::BadReply);
  run.krc.tamper = nullptr;
  run.cycles(100);
  CHECK(run.reason() == FriReason::JointJump);
  CHECK_FALSE(run.arm->status().may_command);
  CHECK(run.krc.worst_dv_rad_s < 0.04);
  CHECK(run.arm->health().last_error.find("A2") != std::string::npos);
  REQUIRE(run.arm->activate());
  run.cycles(10);
  CHECK(run.arm->status().may_command);
}

TEST_CASE("a joint that keeps its last bit while it is commanded to move is stuck (row 46)",
          "[fri][faults]") {
  Moving run;
  run.cycles(100);
  run.krc.frozen = true;
  run.cycles(150);
  CHECK(run.reason() == FriReason::JointStuck);
  CHECK_FALSE(run.arm->status().may_command);
  run.krc.frozen = false;
}

TEST_CASE("an arm that rests is not stuck", "[fri][faults]") {
  Moving run;
  run.speed = 0.0;
  run.krc.frozen = true;
  run.cycles(1000);
  CHECK(run.arm->status().may_command);
}

TEST_CASE("under load from outside command mode is not asked for (row 47)", "[fri][faults]") {
  FakeKrc krc;
  krc.m.tau_external_nm[3] = -25.0f;
  const auto arm = krc.arm();
  REQUIRE(arm->configure());
  const auto refused = arm->activate();
  REQUIRE_FALSE(refused);
  CHECK(refused.error().detail.find("external torque on A4: 25.0") != std::string::npos);
}

}  // namespace colift
