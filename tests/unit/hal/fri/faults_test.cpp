// What the link and the controller can do wrong, rows 36 to 48 of the fault table, and what the driver does.
#include <catch2/catch.hpp>
#include <cmath>
#include <random>

#include "fake_krc.hpp"
#include "hal/fri/fri_driver.hpp"

namespace colift {
namespace {

using hal::ErrorCode;
using hal::FriDrop;
using hal::FriReason;
using hal::FriSession;
using hal::JointVector;
using test::FakeKrc;

constexpr double kT = 0.002;

/// A driver in command mode whose user moves A1 and A4 to and fro, from the measured pose, as a good user
/// does: one period's step for each state, anew from the measured pose whenever commands were not allowed.
struct Moving {
  FakeKrc krc;
  std::unique_ptr<hal::FriArm> arm;
  JointVector q = JointVector::Zero();
  double phase = 0.0, speed = 0.2;
  bool running = false;
  int timeouts = 0, refusals = 0, allowed = 0, lost = 0;

  explicit Moving(const hal::FriConfig& config = FakeKrc::quick()) {
    arm = krc.arm(config);
    REQUIRE(arm->configure());
    REQUIRE(arm->activate());
    cycles(50);
  }
  ~Moving() {
    krc.tamper = nullptr;  // what they refer to is gone before the arm is
    krc.after = nullptr;
  }

  void cycles(int n) {
    for (int i = 0; i < n; ++i) cycle();
  }
  void cycle() {
    const auto s = arm->wait_cycle();
    if (!s) {
      timeouts += s.error().code == ErrorCode::Timeout;
      lost += s.error().code == ErrorCode::LinkLost;
      CHECK(s.error().where.size() <= 15);
      CHECK(s.error().detail.size() <= 15);
      if (s.error().code != ErrorCode::Timeout) running = false;
      return;
    }
    if (!s->may_command) {
      running = false;
      return;
    }
    ++allowed;
    if (!running) {
      q = s->q_rad;
      phase = 0.0;
      running = true;
    } else {
      phase += kT;
      const double v = speed * std::min(1.0, phase / 0.1);
      q[0] += v * std::sin(3.0 * phase) * kT;
      q[3] += v * kT * std::sin(2.0 * phase);
    }
    hal::ImpedanceCommand c;
    c.q_rad = q;
    if (!arm->command(c)) ++refusals;
  }
  void lose(int n) {
    krc.silent = true;
    const auto until = krc.clock.now() + std::chrono::nanoseconds(static_cast<std::int64_t>(n * kT * 1e9));
    while (krc.clock.now() < until) cycle();
    krc.silent = false;
  }
  [[nodiscard]] FriReason reason() const { return arm->status().reason; }
};

std::vector<std::byte> good_bytes(const hal::FriMeasurement& m) {
  std::vector<std::byte> bytes(hal::kFriMeasurementBytes);
  hal::encode(m, std::span<std::byte, hal::kFriMeasurementBytes>(bytes));
  return bytes;
}

}  // namespace

TEST_CASE("one to three lost datagrams make no step (row 36)", "[fri][faults]") {
  const int n = GENERATE(1, 2, 3);
  const bool extrapolates = GENERATE(true, false);
  const bool answers_lost = GENERATE(true, false);
  Moving run;
  run.krc.extrapolates = extrapolates;
  run.cycles(150);
  run.krc.worst_dv_rad_s = run.krc.worst_step_rad = 0.0;
  for (int i = 0; i < 20; ++i) {
    if (answers_lost) {
      run.krc.deaf = true;
      run.cycles(n);
      run.krc.deaf = false;
    } else {
      run.lose(n);
    }
    run.cycles(40);
  }
  INFO(n << " lost, " << (extrapolates ? "extrapolated" : "held") << (answers_lost ? ", answers" : ""));
  CHECK(run.refusals == 0);
  CHECK(run.arm->status().may_command);
  CHECK(run.reason() == FriReason::None);
  CHECK(run.krc.twice == 0);
  // what the controller sees changes by no more than the speed that it bridged with, or without
  CHECK(run.krc.worst_step_rad <= (extrapolates || !answers_lost ? 1.6 : 4.2) * run.speed * kT);
  if (extrapolates) CHECK(run.krc.worst_dv_rad_s < 0.06);
}

TEST_CASE("four or five lost datagrams are not yet a gap (row 36)", "[fri][faults]") {
  const int n = GENERATE(4, 5);
  const double period_s = GENERATE(0.001, 0.002, 0.01);
  FakeKrc krc(period_s);
  const auto arm = krc.arm();
  REQUIRE(arm->configure());
  REQUIRE(arm->activate());
  hal::ImpedanceCommand c;
  c.q_rad = arm->wait_cycle()->q_rad;
  krc.tamper = [n, i = 0](hal::FriMeasurement&) mutable { return i++ % 20 < 20 - n; };
  for (int i = 0; i < 200; ++i) {
    const auto s = arm->wait_cycle();
    if (!s) {
      CHECK(s.error().code == ErrorCode::Timeout);
      continue;
    }
    CHECK(s->may_command);
    CHECK(arm->command(c));
  }
  CHECK(arm->status().lost >= static_cast<std::uint64_t>(8 * n));
}

TEST_CASE("more than five lost: at rest, then from the measured pose, not to the old target (row 36)",
          "[fri][faults]") {
  const int n = GENERATE(6, 7, 10, 20, 40);
  Moving run;
  run.cycles(200);
  const JointVector old = run.q;
  const std::size_t before = run.krc.heard.size();
  run.lose(n);
  // the controller was pushed elsewhere in the meantime
  run.krc.offset_rad[5] += 0.05f;
  run.krc.worst_dv_rad_s = 0.0;
  run.cycles(1);
  CHECK_FALSE(run.arm->status().may_command);
  CHECK(run.reason() == FriReason::Gap);
  // a user who insists on the old target is refused
  hal::ImpedanceCommand insist;
  insist.q_rad = old;
  for (int i = 0; i < 40; ++i) {
    const auto s = run.arm->wait_cycle();
    REQUIRE(s);
    const auto done = run.arm->command(insist);
    REQUIRE_FALSE(done);
    CHECK(done.error().code == (s->may_command ? ErrorCode::LimitExceeded : ErrorCode::NotReady));
  }
  run.cycles(10);
  INFO(hal::short_words(run.reason()));
  CHECK(run.arm->status().may_command);
  run.cycles(100);
  CHECK(run.krc.worst_dv_rad_s < 0.02);
  CHECK(run.krc.heard.size() > before + 100);
  CHECK(run.refusals == 0);
}

TEST_CASE("a tenth of a second of silence is a lost link, which comes back without moving (row 36)",
          "[fri][faults]") {
  Moving run;
  run.lose(80);
  CHECK(run.lost > 0);
  CHECK(run.timeouts >= 40);
  CHECK(run.arm->status().session == FriSession::Silent);
  CHECK(run.arm->health().state == hal::DeviceHealth::State::Lost);
  CHECK(run.arm->health().last_error.find("100 ms") != std::string::npos);
  const int allowed = run.allowed;
  run.cycles(200);
  CHECK(run.allowed == allowed);
  CHECK(run.reason() == FriReason::LinkLost);
  REQUIRE(run.arm->activate());
  run.cycles(20);
  CHECK(run.allowed == allowed + 20);
  CHECK(run.krc.twice == 0);
}

TEST_CASE("random losses of 1 and 10 percent in both directions (row 36)", "[fri][faults]") {
  const double part = GENERATE(0.01, 0.10);
  Moving run;
  std::mt19937 random(7);
  std::uniform_real_distribution<double> draw(0.0, 1.0);
  run.krc.worst_dv_rad_s = 0.0;
  for (int i = 0; i < 5000; ++i) {
    run.krc.silent = draw(random) < part;
    run.krc.deaf = draw(random) < part;
    run.cycle();
  }
  CHECK(run.refusals == 0);
  CHECK(run.krc.twice == 0);
  CHECK(run.krc.not_mirrored == 0);
  CHECK(run.arm->status().lost > 5000 * part / 2);
  CHECK(run.krc.worst_step_rad < 2.2 * kT * run.speed * 4);
  CHECK(run.allowed > 5000 * (1.0 - 2.5 * part));
}

TEST_CASE("doubled and reordered datagrams are dropped and answered by nobody (row 37)", "[fri][faults]") {
  Moving run;
  std::vector<std::byte> older;
  int i = 0;
  run.krc.after = [&](const std::vector<std::byte>& bytes) {
    ++i;
    if (i % 3 == 0) run.krc.wire.inject(run.krc.own, run.krc.pc, bytes);
    if (i % 5 == 0 && !older.empty()) run.krc.wire.inject(run.krc.own, run.krc.pc, older);
    older = bytes;
  };
  run.krc.worst_dv_rad_s = 0.0;
  run.cycles(600);
  CHECK(run.krc.twice == 0);
  CHECK(run.refusals == 0);
  CHECK(run.krc.worst_dv_rad_s < 0.02);
  const auto drops = run.arm->status().drops;
  CHECK(drops[static_cast<std::size_t>(FriDrop::Doubled)] >= 190);
  CHECK(drops[static_cast<std::size_t>(FriDrop::Old)] >= 100);
  CHECK(run.arm->health().rejected >= 290);
}

TEST_CASE("corrupt, short, long and foreign datagrams are dropped, each by its reason (row 38)",
          "[fri][faults]") {
  Moving run;
  const hal::Endpoint stranger{0x0A000001, 5555}, neighbour{0x7F000001, 40000};
  int i = 0;
  run.krc.tamper = [&](hal::FriMeasurement& m) {
    auto bytes = good_bytes(m);
    auto other = m;
    other.head.send = static_cast<std::uint16_t>(m.head.send + 3);
    other.q_measured_rad[2] = 1.0f;
    switch (i++ % 8) {
      case 0:
        run.krc.wire.inject(stranger, run.krc.pc, good_bytes(other));
        break;
      case 1:
        run.krc.wire.inject(neighbour, run.krc.pc, good_bytes(other));
        break;
      case 2:
        run.krc.wire.inject(run.krc.own, run.krc.pc, std::span(bytes).first(915));
        break;
      case 3:
        bytes.resize(1400);
        run.krc.wire.inject(run.krc.own, run.krc.pc, bytes);
        break;
      case 4:
        other.head.id = 0x2007;
        run.krc.wire.inject(run.krc.own, run.krc.pc, good_bytes(other));
        break;
      case 5:
        other.q_measured_rad[0] = std::nanf("");
        run.krc.wire.inject(run.krc.own, run.krc.pc, good_bytes(other));
        break;
      case 6:
        other.q_measured_rad[1] = -2.5f;
        run.krc.wire.inject(run.krc.own, run.krc.pc, good_bytes(other));
        break;
      default:
        other = m;
        other.head.send = static_cast<std::uint16_t>(m.head.send + 9000);
        run.krc.wire.inject(run.krc.own, run.krc.pc, good_bytes(other));
    }
    return true;
  };
  run.krc.worst_dv_rad_s = 0.0;
  run.cycles(800);
  CHECK(run.refusals == 0);
  CHECK(run.krc.twice == 0);
  CHECK(run.krc.worst_dv_rad_s < 0.02);
  const auto d = run.arm->status().drops;
  CHECK(d[static_cast<std::size_t>(FriDrop::Sender)] == 200);
  CHECK(d[static_cast<std::size_t>(FriDrop::Size)] == 200);
  CHECK(d[static_cast<std::size_t>(FriDrop::Header)] == 100);
  CHECK(d[static_cast<std::size_t>(FriDrop::Content)] == 200);
  CHECK(d[static_cast<std::size_t>(FriDrop::Ahead)] == 100);
}

TEST_CASE("of a burst only the newest is answered, and time is the datagram's (row 39)", "[fri][faults]") {
  Moving run;
  std::vector<std::vector<std::byte>> held;
  int left = 25;
  auto last = run.arm->wait_cycle()->measured_at;
  run.krc.tamper = [&](hal::FriMeasurement& m) {
    if (left == 0) return true;
    held.push_back(good_bytes(m));
    if (--left == 0)
      for (const auto& b : held) run.krc.wire.inject(run.krc.own, run.krc.pc, b);
    return false;
  };
  const std::size_t before = run.krc.heard.size();
  int states = 0;
  for (int i = 0; i < 60 && states == 0; ++i) {
    const auto s = run.arm->wait_cycle();
    if (!s) continue;
    ++states;
    CHECK_FALSE(s->may_command);
    CHECK(hal::seconds(s->measured_at - last) == Approx(25 * kT).margin(1e-6));
    last = s->measured_at;
  }
  REQUIRE(states == 1);
  const auto s = run.arm->wait_cycle();
  REQUIRE(s);
  CHECK(hal::seconds(s->measured_at - last) == Approx(kT).margin(1e-6));
  CHECK(run.krc.heard.size() <= before + 2);
  CHECK(run.krc.twice == 0);
  CHECK(run.arm->status().drops[static_cast<std::size_t>(FriDrop::Superseded)] == 24);
  run.cycles(100);
  CHECK(run.arm->status().may_command);
}

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
    run.lose(500);
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
  CHECK(refused.error().detail.find("A4 feels 25.0") != std::string::npos);
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

TEST_CASE("a caller who was away for long is no fault of the counter", "[fri][faults]") {
  FakeKrc krc;
  krc.start_when_good = false;
  const auto arm = krc.arm();
  REQUIRE(arm->configure());
  // a kernel keeps the oldest datagrams of ten seconds and drops the rest
  for (int i = 0; i < 5000; ++i) {
    krc.silent = i > 100;
    (void)krc.run(krc.clock.now() + std::chrono::milliseconds(2));
  }
  krc.silent = false;
  for (int i = 0; i < 300; ++i) (void)arm->wait_cycle();
  CHECK(arm->status().session == FriSession::Monitor);
  CHECK(arm->status().drops[static_cast<std::size_t>(FriDrop::Ahead)] == 0);
  CHECK(arm->wait_cycle());
}

}  // namespace colift
