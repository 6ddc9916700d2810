// The driver's ordinary life against a small controller: mirror, watch, stop, end.
#include <atomic>
#include <cmath>
#include <thread>

#include "fri_arm_rig.hpp"

namespace colift {

using namespace test;

TEST_CASE("before anybody asks, every datagram is answered with the controller's own position",
          "[fri][arm]") {
  FakeKrc krc;
  krc.start_when_good = false;
  krc.offset_rad = {0.011f, -0.023f, 0.007f, 0.013f, 0, 0, 0.001f};
  krc.sag_rad = {0.02f, 0.01f, 0, 0, 0, 0, 0};
  const auto arm = krc.arm();
  REQUIRE(arm->configure());
  for (int i = 0; i < 200; ++i) CHECK_FALSE(next(*arm).may_command);
  CHECK(krc.not_mirrored == 0);
  CHECK(krc.torque_outside == 0);
  CHECK(krc.twice == 0);
  CHECK(krc.heard.size() >= 200);
  CHECK(arm->status().session == FriSession::Monitor);
  CHECK(arm->status().pose_mismatch_rad == Approx(0.02).margin(1e-6));
}

TEST_CASE("a header counts, reflects, and names its size", "[fri][arm]") {
  FakeKrc krc;
  krc.start_when_good = false;
  const auto arm = krc.arm();
  REQUIRE(arm->configure());
  for (int i = 0; i < 20; ++i) next(*arm);
  for (std::size_t i = 1; i < krc.heard.size(); ++i) {
    CHECK(krc.heard[i].head.send == krc.heard[i - 1].head.send + 1);
    CHECK(krc.heard[i].head.reflected == krc.heard[i - 1].head.reflected + 1);
    CHECK(krc.heard[i].head.id == 0x1005);
    CHECK(krc.heard[i].head.size == 376);
  }
}

TEST_CASE("measured time counts sample times, whatever the network does to the datagrams", "[fri][arm]") {
  FakeKrc krc;
  krc.start_when_good = false;
  const auto arm = krc.arm();
  REQUIRE(arm->configure());
  auto last = next(*arm).measured_at;
  for (int i = 0; i < 300; ++i) {
    // the thread comes late, as on a busy machine
    if (i % 7 == 0) krc.clock.advance(std::chrono::microseconds(900));
    const auto at = next(*arm).measured_at;
    CHECK(std::abs(hal::seconds(at - last) - 0.002) < 1e-6);
    last = at;
  }
}

TEST_CASE("counters wrap after 65535", "[fri][arm]") {
  FakeKrc krc(0.001);
  const auto arm = krc.arm();
  REQUIRE(arm->configure());
  REQUIRE(arm->activate());
  const JointVector q = next(*arm).q_rad;
  auto last = next(*arm).measured_at;
  for (int i = 0; i < 70000; ++i) {
    const auto s = arm->wait_cycle();
    REQUIRE(s);
    REQUIRE(arm->command(hold_at(q)));
    if (std::abs(hal::seconds(s->measured_at - last) - 0.001) > 1e-6) FAIL("time stepped at " << i);
    last = s->measured_at;
    if (krc.heard.size() > 1000) krc.heard.clear();
    if (krc.told.size() > 1000) krc.told.clear();
  }
  CHECK(arm->status().lost == 0);
  CHECK(krc.twice == 0);
}

TEST_CASE("external torque and wrench come with the sign that was set", "[fri][arm]") {
  FakeKrc krc;
  krc.start_when_good = false;
  for (std::size_t i = 0; i < 6; ++i) krc.m.wrench_external[i] = static_cast<float>(i + 1);
  krc.m.tau_external_nm[2] = 4.0f;
  hal::FriConfig config = FakeKrc::quick();
  const bool reversed = GENERATE(false, true);
  if (reversed) config.external_torque = "on_environment";
  const auto arm = krc.arm(config);
  REQUIRE(arm->configure());
  const double sign = reversed ? -1.0 : 1.0;
  CHECK(next(*arm).tau_external_nm[2] == 4.0 * sign);
  hal::SixVector expected;
  expected << 1, 2, 3, 6, 5, 4;  // the wire has Tz Ty Tx
  CHECK(arm->external_wrench() == sign * expected);
}

TEST_CASE("deactivate() comes to rest, has command mode left, and answers on", "[fri][arm]") {
  FakeKrc krc;
  krc.script_colift = true;
  hal::FriConfig config = FakeKrc::quick();
  config.script = "colift";
  const auto arm = krc.arm(config);
  REQUIRE(arm->configure());
  REQUIRE(arm->activate());
  JointVector q = next(*arm).q_rad;
  for (int i = 0; i < 100; ++i) {
    REQUIRE(arm->command(hold_at(q)));
    q[0] += std::min(0.0008, 2e-5 * i);
    next(*arm);
  }
  krc.worst_dv_rad_s = 0.0;
  const std::size_t before = krc.heard.size();
  arm->deactivate();
  CHECK(krc.m.state == hal::FriState::Monitor);
  CHECK(krc.worst_dv_rad_s < 0.04);
  CHECK(krc.heard.size() > before + 100);
  CHECK(krc.heard.back().krl.integer[1] == 0);  // nothing is asked for any more
  CHECK(krc.not_mirrored == 0);
  CHECK_FALSE(next(*arm).may_command);
  // a second session on the same link
  REQUIRE(arm->activate());
  CHECK(next(*arm).may_command);
}

TEST_CASE("the arm tells its condition from another thread's side", "[fri][arm]") {
  FakeKrc krc;
  const auto arm = krc.arm();
  CHECK(arm->health().state == hal::DeviceHealth::State::Absent);
  REQUIRE(arm->configure());
  CHECK(arm->health().state == hal::DeviceHealth::State::Opening);
  REQUIRE(arm->activate());
  next(*arm);
  CHECK(arm->health().state == hal::DeviceHealth::State::Streaming);
  CHECK(arm->health().accepted == 1);
  CHECK(arm->health().rejected == 0);
  CHECK(arm->health().last_error.empty());
  CHECK(arm->measurement().q_measured_rad == krc.told.back().q_measured_rad);
  CHECK(arm->answer_times().count() > 20);
  std::vector<FriSession> seen;
  while (const auto event = arm->next_event())
    if (seen.empty() || seen.back() != event->session) seen.push_back(event->session);
  CHECK(seen == std::vector{FriSession::Monitor, FriSession::GettingReady, FriSession::Command});
}

TEST_CASE("another thread may watch and stop while cycles run", "[fri][arm]") {
  FakeKrc krc;
  const auto arm = krc.arm();
  REQUIRE(arm->configure());
  REQUIRE(arm->activate());
  std::atomic<bool> end{false};
  std::atomic<int> wrong{0};
  std::thread other([&] {
    std::uint64_t last = 0;
    while (!end) {
      const hal::FriStatus s = arm->status();
      wrong += s.answered < last;
      wrong += s.received + 1 < s.answered;
      last = s.answered;
      (void)arm->health();
      (void)arm->external_wrench();
      (void)arm->next_event();
      if (last > 1500) arm->stop();
    }
  });
  int stopped = 0;
  for (int i = 0; i < 20000 && stopped == 0; ++i) {
    const auto s = next(*arm);
    if (s.may_command)
      (void)arm->command(hold_at(s.q_rad));
    else
      ++stopped;
  }
  end = true;
  other.join();
  CHECK(stopped == 1);
  CHECK(wrong == 0);
}

TEST_CASE("nothing comes: the words say where to look", "[fri][arm]") {
  FakeKrc krc;
  krc.silent = true;
  const auto arm = krc.arm();
  const auto failed = arm->configure();
  REQUIRE_FALSE(failed);
  CHECK(failed.error().code == ErrorCode::LinkLost);
  CHECK(failed.error().detail.find("49938") != std::string::npos);
  CHECK_FALSE(arm->wait_cycle());
  krc.silent = false;
  CHECK(arm->configure());
}

TEST_CASE("a server that leaves its header empty is heard when nobody looks at it", "[fri][arm]") {
  FakeKrc krc;
  krc.tamper = [](hal::FriMeasurement& m) {
    m.head = {};
    return true;
  };
  hal::FriConfig config = FakeKrc::quick();
  SECTION("by default it is not, and the words say how") {
    const auto failed = krc.arm(config)->configure();
    REQUIRE_FALSE(failed);
    CHECK(failed.error().detail.find("check_header") != std::string::npos);
  }
  SECTION("with both checks off") {
    config.check_header = config.check_sequence = false;
    const auto arm = krc.arm(config);
    REQUIRE(arm->configure());
    REQUIRE(arm->activate());
    JointVector q = next(*arm).q_rad;
    for (int i = 0; i < 50; ++i) {
      REQUIRE(arm->command(hold_at(q)));
      q[1] += 0.0001;
      CHECK(hal::seconds(next(*arm).measured_at) > 0.0);
    }
    CHECK(static_cast<double>(krc.heard.back().q_rad[1]) == Approx(q[1]).margin(2e-4));
  }
}

TEST_CASE("an arm that is shut down leaves zeros behind, and can be configured anew", "[fri][arm]") {
  FakeKrc krc;
  hal::FriConfig config = FakeKrc::quick();
  config.script = "vendor";
  const auto arm = krc.arm(config);
  REQUIRE(arm->configure());
  REQUIRE(arm->activate());
  next(*arm);
  CHECK(krc.heard.back().krl.integer[0] == 10);
  krc.monitor_mode();
  arm->shut_down();
  (void)krc.run(krc.clock.now() + std::chrono::milliseconds(3));
  CHECK(krc.heard.back().krl == hal::KrlChannels{});
  CHECK_FALSE(arm->wait_cycle());
  REQUIRE(arm->configure());
  CHECK(arm->status().received > 0);
  krc.start_when_good = true;
  CHECK(arm->activate());
}

TEST_CASE("a KRC whose address is no address is a matter of configuration", "[fri][arm]") {
  FakeKrc krc;
  hal::FriConfig config = FakeKrc::quick();
  config.krc = "kuka";
  const auto failed = krc.arm(config)->configure();
  REQUIRE_FALSE(failed);
  CHECK(failed.error().code == ErrorCode::BadConfig);
  CHECK_FALSE(hal::make_fri_arm(config, krc.clock));
}

}  // namespace colift
