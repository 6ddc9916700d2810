// From the device's codes and counter to metres and the robot's time.

#include <catch2/catch.hpp>
#include <cmath>
#include <random>

#include "hal/drivers/kinect/depth_table.hpp"
#include "hal/drivers/kinect/device_clock.hpp"
#include "hal/drivers/kinect/kinect_facts.hpp"
#include "hal/drivers/kinect/lost_packets.hpp"

using namespace colift::hal;
using namespace colift::hal::kinect;
using namespace std::chrono_literals;

TEST_CASE("codes become the depths that recorded Kinects have", "[kinect]") {
  const DepthTable table;
  // published pairs, nominal device
  const std::pair<double, int> pairs[] = {{0.5, 398}, {0.8, 658}, {1.0, 744},  {1.5, 859}, {2.0, 917},
                                          {2.5, 951}, {3.0, 974}, {4.0, 1003}, {8.0, 1046}};
  for (const auto& [z, raw] : pairs) {
    const double got = static_cast<double>(table.metres(static_cast<std::uint16_t>(raw)));
    CHECK(std::abs(got - z) < 0.5 * z * z / 345.5 + 0.001);
    // whole millimetres, cut off
    CHECK(std::abs(1000.0 * got - std::round(1000.0 * got)) < 1e-3);
  }
}

TEST_CASE("what is no depth is not a number", "[kinect]") {
  const DepthTable table;
  for (const int raw : {0, 100, 225, 1055, 1089, 1090, 1500, 2046, 2047, 2048, 65535})
    CHECK(std::isnan(table.metres(static_cast<std::uint16_t>(raw))));
  CHECK(table.nearest_code(std::nanf("")) == kNoDepth);
  CHECK(table.nearest_code(-1.0f) == kNoDepth);
}

TEST_CASE("each depth leads back to its own code", "[kinect]") {
  const DepthTable table;
  for (std::uint16_t raw = 400; raw < 1050; ++raw) {
    const float z = table.metres(raw);
    CHECK(table.metres(table.nearest_code(z)) == z);
  }
}

TEST_CASE("constants that no Kinect has are not believed", "[kinect]") {
  CHECK(plausible({}));
  CHECK(plausible({7.5, 120.0, 0.1052, 200.0}));  // its cousin of another maker
  CHECK_FALSE(plausible({0.0, 120.0, 0.1042, 200.0}));
  CHECK_FALSE(plausible({7.5, 1200.0, 0.1042, 200.0}));
  CHECK_FALSE(plausible({7.5, 120.0, std::nan(""), 200.0}));
}

TEST_CASE("the device's time goes on when its counter wraps", "[kinect]") {
  DeviceClock clock;
  std::uint32_t ticks = 4294967295u - 5'000'000u;
  Timestamp last = clock.note(ticks, 100s).device;
  for (int i = 1; i < 10; ++i) {
    ticks += 2'000'000u;
    const Timestamp now = clock.note(ticks, 100s + i * Duration(33'333'333)).device;
    CHECK(seconds(now - last) == Approx(1.0 / 30.0).epsilon(1e-6));
    last = now;
  }
}

TEST_CASE("minutes without a frame are whole wraps that only the host knows of", "[kinect]") {
  DeviceClock clock;
  (void)clock.note(1000, 0s);
  const double after = 200.0;
  const auto ticks = static_cast<std::uint32_t>(static_cast<std::uint64_t>(after * kTicksPerSecond) + 1000);
  // the delivery is half a second late; the device's own time is exact all the same
  const auto t = clock.note(ticks, Timestamp(200'500ms));
  CHECK(seconds(t.device) == Approx(after).margin(1e-6));
}

TEST_CASE("a frame from before does not move time backwards by a wrap", "[kinect]") {
  DeviceClock clock;
  (void)clock.note(10'000'000, 1s);
  const auto newer = clock.note(12'000'000, 1033ms);
  const auto older = clock.note(10'000'000, 1034ms);
  CHECK(older.device < newer.device);
  CHECK(seconds(newer.device - older.device) == Approx(1.0 / 30.0).epsilon(1e-6));
}

TEST_CASE("late deliveries do not move the time of exposure; a drifting clock is followed", "[kinect]") {
  DeviceClock clock;
  std::mt19937 random(7);
  std::exponential_distribution<double> late_ms(1.0 / 8.0);
  double worst = 0.0;
  constexpr double kDrift = 100e-6;
  for (int i = 0; i < 3000; ++i) {
    const double truth = i / 30.0;
    const auto ticks =
        static_cast<std::uint32_t>(static_cast<std::uint64_t>(truth * (1.0 + kDrift) * kTicksPerSecond));
    const double arrives = truth + 1e-3 * late_ms(random);
    const auto t = clock.note(ticks, Timestamp(std::llround(1e9 * arrives)));
    if (i > 300) worst = std::max(worst, std::abs(seconds(t.exposed) - truth));
  }
  CHECK(worst < 0.002);
}

TEST_CASE("lost packets are read from the library's log", "[kinect]") {
  CHECK(lost_packets("[Stream 70] Lost 3 packets") == 3);
  CHECK(lost_packets("[Stream 70] Lost 12 total packets in 3 frames").has_value() == false);
  CHECK(lost_packets("[Stream 70] Lost too many packets, resyncing...").value() > 5);
  CHECK_FALSE(lost_packets("[Stream 80] Lost 3 packets"));
  CHECK_FALSE(lost_packets("[Stream 70] Lost -3 packets"));
  CHECK_FALSE(lost_packets("[Stream 70] Lost"));
  CHECK_FALSE(lost_packets(""));
}

TEST_CASE("what a lost packet leaves in a frame is found, and a scene at rest is not", "[kinect]") {
  std::mt19937 random(3);
  std::vector<std::uint16_t> before(kPixels), frame(kPixels);
  for (std::size_t i = 0; i < kPixels; ++i) {
    before[i] = static_cast<std::uint16_t>(800 + random() % 4);
    frame[i] = static_cast<std::uint16_t>(800 + random() % 4);
  }
  CHECK(stale_runs(frame, before) == 0);
  // packet 40 of the frame did not come: its place holds the old bytes
  for (std::size_t i = 40 * 1748 * 8 / 11; i < 41 * 1748 * 8 / 11 + 1; ++i) frame[i] = before[i];
  CHECK(stale_runs(frame, before) == 1);
  CHECK(stale_runs(before, before) == 0);  // a camera without noise in front of a wall
  CHECK(stale_runs(frame, {}) == 0);
  // a run that sees nothing says nothing
  for (std::size_t i = 40 * 1748 * 8 / 11; i < 41 * 1748 * 8 / 11 + 1; ++i) frame[i] = before[i] = kNoDepth;
  CHECK(stale_runs(frame, before) == 0);
}
