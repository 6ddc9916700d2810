// The driver's state machine alone, under any order of events.
#include "hal/drivers/kuka_fri/session.hpp"

#include <catch2/catch.hpp>
#include <cstring>
#include <random>
#include <set>
#include <string>

namespace colift::hal {
namespace {

SessionMachine::Settings settings() {
  SessionMachine::Settings s;
  s.velocity_rad_s = JointVector::Constant(2.0);
  return s;
}

FriMeasurement good(FriState state) {
  FriMeasurement m;
  m.state = state;
  m.quality = FriQuality::Perfect;
  m.control = FriControl::JointImpedance;
  m.power = kFriAllDrives;
  m.temperature_c.fill(30.0f);
  return m;
}

}  // namespace

TEST_CASE("whatever happens, commands need a confirmation, command mode, drives and quality",
          "[fri][session]") {
  std::mt19937 random(11);
  const auto draw = [&](int n) { return static_cast<int>(random() % static_cast<unsigned>(n)); };
  SessionMachine s(settings());
  bool confirmed = false;
  int allowed = 0;
  std::set<FriReason> reasons;
  std::set<FriSession> sessions;
  FriMeasurement m = good(FriState::Monitor);
  for (int i = 0; i < 300000; ++i) {
    const bool before = s.may_command();
    bool measured = false;
    switch (draw(40)) {
      case 0:
        s.activate();
        confirmed = true;
        break;
      case 1:
        if (draw(8) == 0) {
          s.stop();
          CHECK_FALSE(s.may_command());
        }
        break;
      case 2:
        if (draw(8) == 0) s.leave();
        break;
      case 3:
        s.forget_requests();
        break;
      case 4:
        s.script(static_cast<ScriptSign>(draw(9)), draw(10), draw(8) == 0);
        break;
      case 5:
        if (draw(4) == 0) s.silence(draw(80), draw(5) == 0, draw(20) == 0);
        break;
      case 6:
        if (draw(3) == 0) (void)s.give_up();
        if (draw(6) == 0) s.refuse(FriReason::SecondSender);
        break;
      default:
        m = good(draw(30) == 0 ? FriState::Monitor : FriState::Command);
        if (draw(60) == 0) m.power = 0x3F;
        if (draw(90) == 0) m.error = 1;
        if (draw(40) == 0) m.quality = static_cast<FriQuality>(draw(4));
        if (draw(90) == 0) m.control = static_cast<FriControl>(draw(4));
        if (draw(90) == 0) m.temperature_c[2] = 90.0f;
        if (draw(90) == 0) m.q_measured_rad[4] = 0.5f;
        if (draw(200) == 0) m.tau_external_nm[1] = 50.0f;
        s.measured(m, draw(50) == 0 ? 8 : 1, 0.002, draw(300) == 0);
        s.sent(JointVector::Constant(0.001 * i), JointVector::Constant(1000.0), draw(3) != 0);
        measured = true;
    }
    sessions.insert(s.session());
    reasons.insert(s.reason());
    REQUIRE(std::strlen(short_words(s.reason())) <= 15);
    if (s.may_command()) {
      ++allowed;
      REQUIRE(confirmed);
      REQUIRE(s.session() == FriSession::Command);
      if (measured) {
        REQUIRE_FALSE(SessionMachine::mirrors(m));
        REQUIRE(m.error == 0);
        REQUIRE(m.quality != FriQuality::Unacceptable);
        REQUIRE(m.control == FriControl::JointImpedance);
      }
    }
    // what was lost by a fault needs a new confirmation
    if (before && (s.session() == FriSession::Fault || s.session() == FriSession::Silent)) confirmed = false;
  }
  CHECK(allowed > 5000);
  CHECK(sessions.size() == 5);
  CHECK(reasons.size() >= 18);
}

TEST_CASE("from every state the way to command mode is activate() and good datagrams", "[fri][session]") {
  std::mt19937 random(12);
  for (int round = 0; round < 500; ++round) {
    SessionMachine s(settings());
    for (int i = 0; i < 50; ++i) {
      FriMeasurement m = good(random() % 2 == 0 ? FriState::Command : FriState::Monitor);
      m.power = random() % 5 == 0 ? 0 : kFriAllDrives;
      m.error = random() % 9 == 0 ? 2 : 0;
      s.measured(m, 1 + static_cast<int>(random() % 9), 0.002, random() % 9 == 0);
      if (random() % 9 == 0) s.activate();
      if (random() % 9 == 0) s.stop();
      if (random() % 9 == 0) s.leave();
      if (random() % 9 == 0) s.silence(60, true, false);
    }
    s.forget_requests();
    s.activate();
    for (int i = 0; i < 3; ++i) s.measured(good(FriState::Monitor), 1, 0.002, false);
    CHECK(s.ask() == Ask::Start);
    for (int i = 0; i < 10; ++i) s.measured(good(FriState::Command), 1, 0.002, false);
    REQUIRE(s.may_command());
    s.leave();
    CHECK_FALSE(s.may_command());
    CHECK(s.ask() == Ask::Stop);
  }
}

}  // namespace colift::hal
