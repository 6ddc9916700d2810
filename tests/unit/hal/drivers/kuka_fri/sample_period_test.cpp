// The sample time comes in the datagram, and every limit of a step is proportional to it: what if it lies?

#include "hal/drivers/kuka_fri/wire/sample_period.hpp"

#include <random>

#include "fri_arm_rig.hpp"
#include "hal/drivers/kuka_fri/wire/lwr_limits.hpp"
#include "hal/guards/cycle_time.hpp"
#include "moving_driver.hpp"

namespace colift {

using namespace test;
using hal::SamplePeriod;
using hal::Timestamp;

namespace {

struct Arrivals {
  SamplePeriod sample;
  Timestamp now{0};
  void packets(int n, double claimed_s, double every_s, bool frozen = false) {
    for (int i = 0; i < n; ++i) {
      now += Timestamp(std::llround(1e9 * every_s));
      sample.packet(claimed_s, now, 1, false, frozen);
    }
  }
};

}  // namespace

TEST_CASE("a sample time is believed once the arrivals agree with it", "[fri][faults]") {
  Arrivals a{SamplePeriod(0.002)};
  a.packets(30, 0.010, 0.010);
  CHECK(a.sample.period_s() == Approx(0.010));
  CHECK(a.sample.limit_s() == Approx(0.010));
  CHECK_FALSE(a.sample.disagrees_s());

  SECTION("another one, in the controller's own time") {
    a.packets(30, 0.005, 0.005);
    CHECK(a.sample.period_s() == Approx(0.005));
  }
  SECTION("not while the arm is commanded with it") {
    a.packets(30, 0.005, 0.005, true);
    CHECK(a.sample.period_s() == Approx(0.010));
    CHECK(a.sample.limit_s() == Approx(0.005));  // the smaller of both
  }
  SECTION("not when the datagrams come otherwise") {
    a.packets(30, 0.020, 0.010);
    CHECK(a.sample.period_s() == Approx(0.010));
    CHECK(a.sample.limit_s() == Approx(0.010));
    CHECK(a.sample.disagrees_s().value() == Approx(0.010));
  }
  SECTION("none outside of what FRI can be opened with") {
    for (const double claimed_s : {0.0, 1e-6, 0.0009, 0.11, 0.5, 1.0}) {
      a.packets(30, claimed_s, claimed_s);
      CHECK(a.sample.period_s() == Approx(0.010));
      CHECK(a.sample.limit_s() == Approx(SamplePeriod::kShortest_s));
    }
  }
}

TEST_CASE("half a second inside datagrams of two milliseconds lets no step through", "[fri][faults]") {
  Moving run;
  run.cycles(100);
  run.krc.worst_step_rad = 0.0;
  run.krc.tamper = [](hal::FriMeasurement& m) {
    m.measurement_period_s = m.command_period_s = 0.5f;
    return true;
  };
  run.cycles(20);
  REQUIRE(run.running);
  hal::ImpedanceCommand c;
  c.q_rad = run.q;
  c.q_rad[0] += 0.3;
  (void)next(*run.arm);
  CHECK_FALSE(run.arm->command(c));
  run.cycles(20);
  CHECK(run.krc.worst_step_rad < 0.005);
  CHECK(run.arm->status().period_s == Approx(kT));
}

TEST_CASE("no distribution of sample times and no user makes a step that is faster than the joint",
          "[fri][faults]") {
  const auto seed = GENERATE(1u, 2u, 3u);
  std::mt19937 draw(seed);
  Moving run;
  run.cycles(100);
  run.krc.worst_step_rad = 0.0;
  const std::array<float, 12> claims{0.0f,  1e-6f, 0.0005f, 0.001f, 0.0019f, 0.002f,
                                     0.01f, 0.05f, 0.1f,    0.11f,  0.5f,    1.0f};
  run.krc.tamper = [&](hal::FriMeasurement& m) {
    m.measurement_period_s = claims[draw() % claims.size()];
    return true;
  };
  std::uniform_real_distribution<double> step(-0.4, 0.4);
  for (int i = 0; i < 2000; ++i) {
    const auto state = run.arm->wait_cycle();
    if (!state || !state->may_command) continue;
    hal::ImpedanceCommand c;
    c.q_rad = state->q_commanded_rad;
    if (draw() % 3 == 0) c.q_rad[static_cast<int>(draw() % 7)] += step(draw) * (draw() % 2 == 0 ? 1.0 : 0.01);
    (void)run.arm->command(c);
  }
  const double fastest = hal::lwr_velocity_rad_s().maxCoeff();
  CHECK(run.krc.worst_step_rad <= fastest * kT * 1.01);
}

TEST_CASE("a datagram that lies about its sample time lengthens no stop and makes none harder",
          "[fri][faults]") {
  const auto way = [](float claim_s) {
    Moving run;
    run.speed = 0.6;
    run.cycles(150);
    run.krc.tamper = [claim_s](hal::FriMeasurement& m) {
      m.measurement_period_s = m.command_period_s = claim_s;
      return true;
    };
    const float from = run.krc.followed()[0];
    run.krc.worst_dv_rad_s = 0.0;
    run.arm->stop();
    for (int i = 0; i < 200; ++i) (void)run.arm->wait_cycle();
    CHECK(run.krc.worst_dv_rad_s <= FakeKrc::quick().acceleration_rad_s2 * kT * 1.05);
    return static_cast<double>(std::abs(run.krc.followed()[0] - from));
  };
  const double honest = way(0.002f);
  CHECK(honest > 1e-3);
  for (const float claim_s : {0.001f, 0.0015f, 0.01f, 0.5f})
    CHECK(way(claim_s) == Approx(honest).epsilon(0.2));
}

TEST_CASE("an arm with a long period can be moved", "[fri][faults]") {
  const double period_s = GENERATE(0.02, 0.05, 0.1);
  FakeKrc krc(period_s);
  hal::FriConfig config = FakeKrc::quick();
  config.cycle_ms = 1e3 * period_s;
  config.first_s = 5.0;
  config.ready_s = 20.0;
  const auto arm = krc.arm(config);
  REQUIRE(arm->configure());
  REQUIRE(arm->activate());
  JointVector q = next(*arm).q_rad;
  const double start = q[0];
  REQUIRE(arm->command(hold_at(q)));
  for (int i = 0; i < 60; ++i) {
    const auto state = arm->wait_cycle();
    REQUIRE(state);
    REQUIRE(state->may_command);
    q[0] += 0.1 * period_s * std::min(1.0, 0.1 * i);
    const auto taken = arm->command(hold_at(q));
    INFO(i << " " << period_s << " " << (taken ? "" : taken.error().text()) << " "
           << arm->status().last_refused.found << " of " << arm->status().last_refused.limit);
    REQUIRE(taken);
  }
  CHECK(krc.followed()[0] > start + 3.0 * period_s);
}

TEST_CASE("a few late states in a row do not stretch the steps", "[guards]") {
  hal::CycleTime time;
  Timestamp now{0};
  const auto advance = [&](int n, int ms) {
    for (int i = 0; i < n; ++i) {
      now += std::chrono::milliseconds(ms);
      (void)time.advance(now);
    }
  };
  advance(20, 5);
  CHECK(time.step_s() == Approx(0.005));
  advance(6, 15);
  CHECK(time.step_s() == Approx(0.005));
  SECTION("a period that stays longer is believed") {
    advance(20, 15);
    CHECK(time.step_s() == Approx(0.015));
  }
  SECTION("a shorter one at once") {
    advance(2, 2);
    CHECK(time.step_s() == Approx(0.002));
  }
}

}  // namespace colift
