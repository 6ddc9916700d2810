#include "hal/drivers/barrett_can/slip_detector.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <optional>

using namespace colift;
using namespace std::chrono_literals;
using hal::barrett::SlipDetector;
using hal::barrett::SlipLimits;

namespace {

using Three = std::array<double, hal::kFingers>;
struct Grip {
  Three inner_rad{1.2, 1.2, 1.2}, strain_nm{0.3, 0.3, 0.6}, pad_n{3.0, 3.0, 6.0};
  std::array<bool, hal::kFingers> holding{true, true, true};
};

// Measured every 10 ms, as the driver does; the grip is changed at 1 s. When the alarm came after that.
std::optional<hal::Duration> alarm_after(const std::function<void(Grip&, hal::Duration since)>& change,
                                         hal::Duration until = 3s) {
  SlipDetector detector({});
  detector.start();
  Grip grip;
  for (hal::Duration t = 0ms; t < until; t += 10ms) {
    if (t >= 1s) change(grip, t - 1s);
    detector.add(hal::Timestamp(t), grip.inner_rad, grip.strain_nm, grip.pad_n, grip.holding);
    if (!detector.slipped()) continue;
    REQUIRE(t >= 1s);
    return t - 1s;
  }
  return std::nullopt;
}

}  // namespace

TEST_CASE("a grip that gives way is a slip within 50 ms", "[slip]") {
  const auto change = GENERATE(
      as<std::function<void(Grip&, hal::Duration)>>{},
      [](Grip& g, hal::Duration) {
        g.strain_nm = {0.1, 0.1, 0.2};
      },
      [](Grip& g, hal::Duration) {
        g.pad_n = {1.0, 1.0, 2.0};
      },
      [](Grip& g, hal::Duration) {
        g.inner_rad = {1.24, 1.24, 1.24};
      },
      [](Grip& g, hal::Duration) { g.inner_rad[1] = 1.3; },  // one alone goes through
      [](Grip& g, hal::Duration) {                           // what turned out of the grip, pads not fitted
        g.strain_nm = {0.4, 0.0, 0.1};
        g.pad_n.fill(std::nan(""));
      });
  const auto after = alarm_after(change);
  REQUIRE(after);
  CHECK(*after <= 30ms);
}

TEST_CASE("a weight that is lifted shifts between the fingers, which is no slip", "[slip]") {
  const auto change = GENERATE(
      as<std::function<void(Grip&, hal::Duration)>>{},
      // all of F1's part goes to F2, at once or within 0.2 s
      [](Grip& g, hal::Duration) {
        g.strain_nm = {0.0, 0.6, 0.6}, g.pad_n = {0.0, 6.0, 6.0};
      },
      [](Grip& g, hal::Duration since) {
        const double x = std::min(1.0, hal::seconds(since) / 0.2);
        g.strain_nm = {0.3 - 0.3 * x, 0.3 + 0.3 * x, 0.6};
        g.pad_n = {3.0 - 3.0 * x, 3.0 + 3.0 * x, 6.0};
      },
      // the object leans on F3: two close by what the third gives
      [](Grip& g, hal::Duration) {
        g.inner_rad = {1.225, 1.225, 1.18};
      },
      // a jerk, three times as much for 30 ms
      [](Grip& g, hal::Duration since) {
        const double k = since < 30ms ? 3.0 : 1.0;
        g.strain_nm = {0.3 * k, 0.3 * k, 0.6 * k}, g.pad_n = {3.0 * k, 3.0 * k, 6.0 * k};
      },
      // the load presses on the fingers, by three quarters of the grip for a second, and goes again, by more
      [](Grip& g, hal::Duration since) {
        const double t = hal::seconds(since);
        const double k =
            t < 1.0 ? 1.0 + 0.75 * std::min(1.0, 2.0 * t) : std::max(0.65, 1.75 - 2.5 * (t - 1.0));
        g.strain_nm = {0.3 * k, 0.3 * k, 0.6 * k}, g.pad_n = {3.0 * k, 3.0 * k, 6.0 * k};
      },
      // the load goes within a second
      [](Grip& g, hal::Duration since) {
        const double k = std::max(0.5, 1.0 - 0.5 * hal::seconds(since));
        g.strain_nm = {0.3 * k, 0.3 * k, 0.6 * k};
      },
      // one bad measurement
      [](Grip& g, hal::Duration since) {
        g.strain_nm = since < 10ms ? Three{0.0, 0.0, 0.0} : Three{0.3, 0.3, 0.6};
        g.inner_rad.fill(since < 10ms ? 1.6 : 1.2);
      },
      // a finger that tells nothing
      [](Grip& g, hal::Duration) { g.strain_nm[2] = g.pad_n[2] = std::nan(""); },
      [](Grip& g, hal::Duration) { g.holding[2] = false; });
  CHECK_FALSE(alarm_after(change));
}

TEST_CASE("a grip that gives way under a load which presses on it is a slip, too", "[slip]") {
  CHECK(alarm_after([](Grip& g, hal::Duration since) {
          const double k = since < 1s ? 1.75 : 0.4;
          g.strain_nm = {0.3 * k, 0.3 * k, 0.6 * k}, g.pad_n = {3.0 * k, 3.0 * k, 6.0 * k};
        }) == 1s + 10ms);
}

TEST_CASE("an alarm stays until the grip is taken for a good one anew", "[slip]") {
  SlipDetector detector({});
  detector.start();
  Grip grip;
  auto feel = [&, t = hal::Timestamp(0)](int times) mutable {
    for (int i = 0; i < times; ++i)
      detector.add(t += 10ms, grip.inner_rad, grip.strain_nm, grip.pad_n, grip.holding);
  };
  feel(100);
  grip.strain_nm = {0.05, 0.05, 0.1};
  feel(5);
  REQUIRE(detector.slipped());
  grip.strain_nm = {0.3, 0.3, 0.6};
  feel(100);
  CHECK(detector.slipped());
  detector.start();
  feel(100);
  CHECK_FALSE(detector.slipped());
}
