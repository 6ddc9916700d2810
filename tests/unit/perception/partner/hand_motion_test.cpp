// A hand that leaves its grasp, in a quiet and in a flickering picture.
#include "perception/partner/hand_motion.hpp"

#include <catch2/catch.hpp>

using namespace colift;
using perception::HandMotion;
using perception::HandSighting;

namespace {

HandSighting seen(double x_m, double area_m2) {
  return {area_m2, area_m2, hal::Vec3(x_m, 0.0, 0.0)};
}

/// One second with noise to both sides.
HandMotion held(double noise_m, double noise_fraction) {
  HandMotion motion{perception::PresenceConfig{}};
  for (int i = 0; i < 30; ++i) {
    const double sign = i % 2 == 0 ? 1.0 : -1.0;
    motion.update(seen(0.04 + sign * noise_m, 0.005 * (1.0 + sign * noise_fraction)));
    CHECK_FALSE(motion.leaves());
  }
  return motion;
}

}  // namespace

TEST_CASE("a hand that leaves is noticed by its first two centimetres, or by what is hidden of it",
          "[presence]") {
  HandMotion away = held(0.001, 0.02);
  away.update(seen(0.06, 0.005));
  CHECK(away.leaves());
  HandMotion hidden = held(0.001, 0.02);
  hidden.update(seen(0.04, 0.0035));
  CHECK(hidden.leaves());
  // half of that: two frames in a row
  HandMotion slow = held(0.001, 0.02);
  slow.update(seen(0.055, 0.005));
  CHECK_FALSE(slow.leaves());
  slow.update(seen(0.058, 0.005));
  CHECK(slow.leaves());
}

TEST_CASE("a place that flickers needs a larger motion, and what comes into view is no hand that leaves",
          "[presence]") {
  HandMotion flickers = held(0.006, 0.2);
  flickers.update(seen(0.06, 0.005));
  CHECK_FALSE(flickers.leaves());
  flickers.update(seen(0.10, 0.004));
  CHECK(flickers.leaves());
  HandMotion other = held(0.001, 0.02);
  other.update(seen(0.07, 0.012));
  CHECK_FALSE(other.leaves());
}
