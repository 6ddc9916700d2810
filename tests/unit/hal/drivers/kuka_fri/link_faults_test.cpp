// What the wire can do wrong, rows 36 to 39 of the fault table, and what the driver does.
#include <random>

#include "moving_driver.hpp"

namespace colift {

using namespace test;

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
      run.note_device(n);
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
  run.note_device(n);
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
  run.note_device(80);
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
