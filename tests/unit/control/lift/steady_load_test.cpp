#include "control/lift/steady_load.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

using namespace colift;

namespace {

using control::SteadyLoad;

constexpr double kCycle_s = 0.005, kMaxChange_n = 0.5;

// When a load that follows `load(t)` has been steady for half a second (s); 20 s where it never has.
double steady_after_s(const auto& load) {
  SteadyLoad steady;
  steady.start();
  for (int i = 0; i < 4000; ++i) {
    steady.update(load(kCycle_s * i), kCycle_s, kMaxChange_n);
    if (steady.steady_s() >= 0.5) return kCycle_s * i;
  }
  return 20.0;
}

TEST_CASE("a load that only trembles is steady", "[steady_load]") {
  const auto trembling = [](double t) { return 17.0 + 2.0 * std::sin(2 * std::numbers::pi * 9.0 * t); };
  CHECK(steady_after_s(trembling) < 1.0);
}

TEST_CASE("a load that fades towards its end is steady when little is left", "[steady_load]") {
  for (const double time_constant_s : {0.3, 0.6, 1.0}) {
    const auto fading = [&](double t) { return 17.0 - 9.0 * std::exp(-t / time_constant_s); };
    const double after_s = steady_after_s(fading);
    CAPTURE(time_constant_s, after_s);
    CHECK(after_s < 6.0);
    CHECK(std::abs(fading(after_s) - 17.0) < 1.0);
  }
}

TEST_CASE("a load that swings is not steady at its turning points", "[steady_load]") {
  const auto swinging = [](double t) { return 17.0 + 5.0 * std::sin(2 * std::numbers::pi * 0.5 * t); };
  CHECK(steady_after_s(swinging) == 20.0);
}

TEST_CASE("readings that are no numbers are left out, and a new start forgets", "[steady_load]") {
  SteadyLoad steady;
  for (int i = 0; i < 200; ++i) steady.update(i % 3 == 0 ? NAN : 12.0, kCycle_s, kMaxChange_n);
  CHECK(steady.steady_s() > 0.5);
  steady.start();
  CHECK(steady.steady_s() == 0.0);
}

}  // namespace
