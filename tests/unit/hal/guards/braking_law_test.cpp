#include "hal/guards/braking_law.hpp"

#include <catch2/catch.hpp>
#include <cmath>

using namespace colift::hal;

namespace {

/// Distance that a joint still moves when it brakes from v with `a` in steps of dt, summed step by step.
double distance_to_rest(double v, double dt, double a) {
  double sum = 0.0;
  while (v > 0.0) {
    v = std::max(0.0, v - a * dt);
    sum += v * dt;
  }
  return sum;
}

}  // namespace

TEST_CASE("the greatest stoppable speed stops before the end, and not much before", "[guard]") {
  for (const double dt : {0.001, 0.005, 0.02})
    for (const double a : {0.5, 5.0, 15.0})
      for (double distance = 1e-6; distance < 3.0; distance *= 1.7) {
        const double v = stoppable_speed(distance, dt, a);
        const double used = v * dt + distance_to_rest(v, dt, a);
        CAPTURE(dt, a, distance, v);
        CHECK(used <= distance * (1.0 + 1e-12));
        // what it leaves is less than the way of two steps
        CHECK(used >= distance - 2.0 * v * dt - a * dt * dt);
      }
}

TEST_CASE("at or beyond the end nothing is stoppable", "[guard]") {
  CHECK(stoppable_speed(0.0, 0.001, 5.0) == 0.0);
  CHECK(stoppable_speed(-0.1, 0.001, 5.0) == 0.0);
}

TEST_CASE("a joint driven at its end with all it may ends there at rest", "[guard]") {
  const JointBounds b{-1.0, 1.0, 2.0, 5.0};
  double q = -1.0, v = 0.0;
  for (int i = 0; i < 5000; ++i) {
    const VelocityRange may = allowed_velocity(q, v, 0.001, b);
    CHECK(may.low <= may.high);
    CHECK(std::abs(may.high - v) <= b.acceleration_rad_s2 * 0.001 + 1e-12);
    v = may.high;
    q += v * 0.001;
    CHECK(q <= 1.0 + 1e-12);
  }
  CHECK(q == Approx(1.0).margin(1e-6));
  CHECK(v == Approx(0.0).margin(1e-3));
}

TEST_CASE("braking goes to rest without turning back", "[guard]") {
  const JointBounds b{-1.0, 1.0, 2.0, 5.0};
  double q = 0.0, v = -1.2345;
  int steps = 0;
  for (; v != 0.0 && steps < 1000; ++steps) {
    const double next = braking_velocity(q, v, 0.001, b);
    CHECK(next <= 0.0);
    CHECK(next > v);
    v = next;
    q += v * 0.001;
  }
  CHECK(steps == 247);
}
