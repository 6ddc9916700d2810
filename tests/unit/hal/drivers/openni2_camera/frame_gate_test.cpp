// Which frames are new, and when they were taken, by a device's count and clock that may say anything.

#include <catch2/catch.hpp>
#include <random>

#include "hal/drivers/openni2_camera/frame_gate.hpp"

using namespace colift::hal;
using namespace colift::hal::openni2;
using namespace std::chrono_literals;

namespace {

constexpr std::uint64_t kPeriod_us = 33'333;

/// A device of 30 Hz whose frames take 5 ms to come.
struct ThirtyHertz {
  FrameGate gate;
  std::uint64_t index = 0, clock_us = 1'000'000;
  Timestamp now = 100s;

  Result<FrameGate::Times> next(Duration late = 0ms) {
    ++index;
    clock_us += kPeriod_us;
    now += Duration(kPeriod_us * 1000);
    return gate.pass(index, clock_us, now + 5ms + late);
  }
};

}  // namespace

TEST_CASE("frames of a device that works are let through at the pace of its clock", "[openni2]") {
  ThirtyHertz d;
  std::mt19937 random(5);
  std::uniform_int_distribution<int> late_us(0, 20'000);
  Timestamp last = Timestamp::min();
  for (int i = 0; i < 300; ++i) {
    const auto t = d.next(std::chrono::microseconds(i == 0 ? 0 : late_us(random)));
    REQUIRE(t);
    CHECK(t->exposed == d.now + 5ms);
    CHECK(t->exposed > last);
    last = t->exposed;
  }
  CHECK(d.gate.counts().skipped == 0);
}

TEST_CASE("a number that comes twice and a frame that is older are dropped, a gap is counted", "[openni2]") {
  ThirtyHertz d;
  REQUIRE(d.next());
  REQUIRE(d.next());
  CHECK_FALSE(d.gate.pass(d.index, d.clock_us, d.now + 6ms));
  CHECK_FALSE(d.gate.pass(d.index, d.clock_us + 100, d.now + 7ms));
  CHECK(d.gate.counts().duplicate == 2);
  CHECK_FALSE(d.gate.pass(d.index - 1, d.clock_us - kPeriod_us, d.now + 8ms));
  CHECK(d.gate.counts().old == 1);
  d.index += 3;
  REQUIRE(d.next());
  CHECK(d.gate.counts().skipped == 3);
  // of five that are missing four came, and nobody read them
  d.index += 6;
  d.clock_us += 6 * kPeriod_us;
  d.now += Duration(6 * kPeriod_us * 1000);
  REQUIRE(d.gate.pass(d.index, d.clock_us, d.now + 5ms, 4));
  CHECK(d.gate.counts().skipped == 4);
  // counting from the beginning again, in the same clock: the time decides
  d.index = 0;
  REQUIRE(d.next());
  CHECK(d.gate.counts().skipped == 4);
}

TEST_CASE("a clock that is set is believed after a while, and the robot's time never goes back",
          "[openni2]") {
  const std::int64_t step_us = GENERATE(3'600'000'000LL, 20'000'000LL, -20'000'000LL, 2'000'000LL);
  ThirtyHertz d;
  d.clock_us = 100'000'000;
  Timestamp last = Timestamp::min();
  const auto count = [&](int frames) {
    int passed = 0;
    for (int i = 0; i < frames; ++i)
      if (const auto t = d.next()) {
        CHECK(t->exposed > last);
        CHECK(t->exposed <= d.now + 5ms);
        CHECK(d.now - t->exposed < 10ms);
        last = t->exposed;
        ++passed;
      }
    return passed;
  };
  CHECK(count(30) == 30);
  d.clock_us = static_cast<std::uint64_t>(static_cast<std::int64_t>(d.clock_us) + step_us);
  CHECK(count(30) == 20);
  CHECK(d.gate.counts().clock_set == 1);
  CHECK(d.gate.counts().misdated == 10);
  CHECK(count(30) == 30);
}

TEST_CASE("frames that waited for seconds and come at once are not taken for new ones", "[openni2]") {
  ThirtyHertz d;
  for (int i = 0; i < 30; ++i) REQUIRE(d.next());
  // 3 s of frames come within 0.1 s
  const Timestamp resumed = d.now + 3s;
  for (int i = 0; i < 90; ++i) {
    ++d.index;
    d.clock_us += kPeriod_us;
    const auto t = d.gate.pass(d.index, d.clock_us, resumed + i * Duration(1'100'000));
    if (t) CHECK(resumed - t->exposed < 1100ms);
  }
  d.now = resumed;
  CHECK(d.gate.counts().clock_set == 0);
  CHECK(d.next(100ms));
}

TEST_CASE("stamps of any size and order neither overflow nor take time back", "[openni2]") {
  std::mt19937_64 random(3);
  FrameGate gate;
  Timestamp now = 50s, last = Timestamp::min();
  for (int i = 0; i < 20'000; ++i) {
    now += Duration(static_cast<std::int64_t>(random() % 50'000'000));
    if (i % 500 == 0) gate.forget();
    const std::uint64_t stamp = random() >> (random() % 64);
    const auto t = gate.pass(random() >> (random() % 64), stamp, now);
    if (!t) continue;
    CHECK(t->exposed > last);
    CHECK(t->exposed <= now);
    last = t->exposed;
  }
}
