// What the controller can do, rows 40 to 44 of the fault table, what the driver does, and how it says so.

#include "moving_driver.hpp"

namespace colift {

using namespace test;

TEST_CASE("bad quality slows, unacceptable quality stops until it is back (row 40)", "[fri][faults]") {
  Moving run;
  run.krc.m.quality = hal::FriQuality::Bad;
  run.cycles(50);
  CHECK(run.arm->status().slow);
  CHECK(run.arm->status().may_command);
  CHECK(run.arm->health().last_error.find("quality bad") != std::string::npos);
  run.krc.m.quality = hal::FriQuality::Unacceptable;
  run.krc.worst_dv_rad_s = 0.0;
  run.cycles(100);
  CHECK_FALSE(run.arm->status().may_command);
  CHECK(run.reason() == FriReason::QualityLost);
  CHECK(run.krc.worst_dv_rad_s < 0.04);
  const auto rest = run.krc.heard.back().q_rad;
  run.cycles(10);
  CHECK(run.krc.heard.back().q_rad == rest);
  run.krc.m.quality = hal::FriQuality::Ok;
  run.cycles(50);
  CHECK(run.arm->status().may_command);
  CHECK_FALSE(run.arm->status().slow);
  CHECK(run.refusals == 0);
}

TEST_CASE("monitor mode ends it until somebody asks, then from the measured pose (row 41)", "[fri][faults]") {
  Moving run;
  run.cycles(100);
  run.krc.monitor_mode();
  run.cycles(200);
  CHECK(run.arm->status().session == FriSession::Monitor);
  CHECK(run.reason() == FriReason::LeftCommand);
  CHECK(run.krc.not_mirrored == 0);
  // the controller goes to command mode again by somebody else's hand: nothing moves
  run.krc.command_mode();
  const int allowed = run.allowed;
  const auto there = run.krc.followed();
  run.cycles(100);
  CHECK(run.allowed == allowed);
  CHECK(run.krc.followed() == there);
  REQUIRE(run.arm->activate());
  run.krc.worst_dv_rad_s = 0.0;
  run.cycles(100);
  CHECK(run.allowed > allowed);
  CHECK(run.krc.worst_dv_rad_s < 0.02);
  CHECK(run.refusals == 0);
}

TEST_CASE("drives off and drive errors: the controller's pose is mirrored, nothing resets by itself (row 42)",
          "[fri][faults]") {
  Moving run;
  run.cycles(100);
  const bool error = GENERATE(true, false);
  const bool monitor = GENERATE(true, false);
  run.krc.m.power = 0;
  if (error) run.krc.m.error = 0x08;
  if (monitor) run.krc.monitor_mode();
  run.cycles(100);
  CHECK(run.arm->status().session == FriSession::Fault);
  CHECK(run.reason() == (error ? FriReason::DriveError : FriReason::DrivesOff));
  CHECK(run.krc.not_mirrored == 0);
  CHECK(run.krc.torque_outside == 0);
  CHECK(run.arm->health().last_error.find(error ? "A4" : "drives are off") != std::string::npos);
  CHECK(run.arm->health().state == hal::DeviceHealth::State::Failed);
  run.krc.m.power = 0x7F;
  run.krc.m.error = 0;
  const int allowed = run.allowed;
  run.cycles(100);
  CHECK(run.allowed == allowed);
  CHECK(run.arm->status().session == FriSession::Fault);
  run.krc.start_when_good = true;
  REQUIRE(run.arm->activate());
  run.cycles(20);
  CHECK(run.allowed == allowed + 20);
  CHECK(run.refusals == 0);
}

TEST_CASE("a single drive that is off is off too, whatever the higher bits say", "[fri][faults]") {
  Moving run;
  run.krc.m.power = 0xFFFF;
  run.cycles(10);
  CHECK(run.arm->status().may_command);
  run.krc.m.power = 0xFFBF;
  run.cycles(10);
  CHECK(run.reason() == FriReason::DrivesOff);
  CHECK(run.krc.not_mirrored == 0);
}

TEST_CASE("a drive's warning or warmth slows, heat ends command mode (row 43)", "[fri][faults]") {
  hal::FriConfig config = FakeKrc::quick();
  config.script = "colift";
  Moving run = [&] {
    // the script's controller instead of the impatient one
    return Moving(FakeKrc::quick());
  }();
  run.krc.m.warning = 0x02;
  run.cycles(10);
  CHECK(run.arm->status().slow);
  CHECK(run.arm->health().last_error.find("A2") != std::string::npos);
  run.krc.m.warning = 0;
  run.krc.m.temperature_c[5] = 72.0f;
  run.cycles(10);
  CHECK(run.arm->status().slow);
  CHECK(run.arm->status().may_command);
  run.krc.m.temperature_c[5] = 86.0f;
  run.krc.worst_dv_rad_s = 0.0;
  run.cycles(50);
  CHECK(run.reason() == FriReason::DriveHot);
  CHECK_FALSE(run.arm->status().may_command);
  CHECK(run.krc.worst_dv_rad_s < 0.04);
  CHECK(run.arm->health().last_error.find("A6") != std::string::npos);
  const auto again = run.arm->activate();
  REQUIRE_FALSE(again);
  CHECK(again.error().code == ErrorCode::DeviceFault);
}

TEST_CASE("heat asks the KRL program to stop, after coming to rest (row 43)", "[fri][faults]") {
  FakeKrc krc;
  krc.script_colift = true;
  hal::FriConfig config = FakeKrc::quick();
  config.script = "colift";
  const auto arm = krc.arm(config);
  REQUIRE(arm->configure());
  REQUIRE(arm->activate());
  krc.m.temperature_c[0] = 90.0f;
  for (int i = 0; i < 50; ++i) CHECK(arm->wait_cycle());
  CHECK(krc.m.state == hal::FriState::Monitor);
  CHECK(arm->status().reason == FriReason::DriveHot);
}

TEST_CASE("a counter that is set back is named, and is not the cable", "[fri][faults]") {
  for (const int by : {300, 2000, -9000}) {
    CAPTURE(by);
    Moving run;
    run.cycles(3000);
    run.krc.count_back(by);
    run.cycles(200);
    const auto status = run.arm->status();
    CHECK(status.reason == FriReason::KrcRestarted);
    CHECK_FALSE(status.may_command);
    const std::string text = why_not(status, run.arm->config());
    INFO(text);
    CHECK(text.find("counts its datagrams anew") != std::string::npos);
  }
}

TEST_CASE("a controller that was switched off and on is met as a new one (row 44)", "[fri][faults]") {
  Moving run;
  run.cycles(300);
  SECTION("quickly") {
    run.krc.reboot();
    run.cycles(200);
    CHECK(run.reason() == FriReason::KrcRestarted);
    CHECK(run.arm->status().session == FriSession::Fault);
  }
  SECTION("slowly") {
    run.note_device(500);
    run.krc.reboot();
    run.cycles(200);
    CHECK(run.reason() == FriReason::LinkLost);
  }
  CHECK_FALSE(run.arm->status().may_command);
  CHECK(run.krc.not_mirrored == 0);
  run.krc.start_when_good = true;
  REQUIRE(run.arm->activate());
  run.cycles(10);
  CHECK(run.arm->status().may_command);
}

TEST_CASE("another control mode than asked for is no ground to command (row 44)", "[fri][faults]") {
  SECTION("at the start") {
    FakeKrc krc;
    krc.m.control = hal::FriControl::Position;
    const auto arm = krc.arm();
    REQUIRE(arm->configure());
    const auto refused = arm->activate();
    REQUIRE_FALSE(refused);
    CHECK(refused.error().code == ErrorCode::NotReady);
    CHECK(refused.error().detail.find("strategy 10") != std::string::npos);
    CHECK(refused.error().detail.find("joint_impedance") != std::string::npos);
  }
  SECTION("later") {
    Moving run;
    run.krc.m.control = hal::FriControl::Other;
    run.cycles(20);
    CHECK(run.reason() == FriReason::WrongControl);
    CHECK_FALSE(run.arm->status().may_command);
    CHECK(run.krc.flags_changed == 0);
  }
}

TEST_CASE("why command mode is refused is said in words", "[fri][faults]") {
  FakeKrc krc;
  krc.start_when_good = false;
  hal::FriConfig config = FakeKrc::quick();
  std::string expected;
  SECTION("quality") {
    krc.m.quality = hal::FriQuality::Bad;
    krc.m.answer_rate = 0.83f;
    expected = "answer rate 0.83";
  }
  SECTION("nobody asks") {
    expected = "a person at the panel";
  }
  SECTION("pose mismatch") {
    krc.sag_rad[2] = 0.05f;
    expected = "A3 is measured 0.050 rad away";
  }
  SECTION("drive error") {
    krc.m.error = 1;
    expected = "drive error of A1";
  }
  SECTION("drives stay off") {
    krc.start_when_good = true;
    krc.m.power = 0;
    expected = "the drives are off";
  }
  SECTION("no such KRL program") {
    config.script = "colift";
    expected = "does not answer within 0.5 s; expected is \"colift\"";
  }
  const auto arm = krc.arm(config);
  REQUIRE(arm->configure());
  const auto began = krc.clock.now();
  const auto refused = arm->activate();
  REQUIRE_FALSE(refused);
  INFO(refused.error().detail);
  CHECK(refused.error().detail.find(expected) != std::string::npos);
  CHECK(hal::seconds(krc.clock.now() - began) < 3.0);
  CHECK(krc.not_mirrored == 0);
  CHECK(krc.twice == 0);
}

TEST_CASE("stop() ends getting ready at once", "[fri][faults]") {
  FakeKrc krc;
  krc.start_when_good = false;
  const auto arm = krc.arm();
  REQUIRE(arm->configure());
  int n = 0;
  krc.after = [&](const auto&) {
    if (++n == 50) arm->stop();
  };
  const auto refused = arm->activate();
  REQUIRE_FALSE(refused);
  CHECK(refused.error().detail.find("stopped") != std::string::npos);
  CHECK(n < 60);
  krc.after = nullptr;
}

}  // namespace colift
