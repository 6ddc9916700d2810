// Figures over random lifts. Limits follow the aims of the project; where one is not reached yet, the limit
// says so.

#include <catch2/catch.hpp>
#include <cmath>
#include <cstdio>

#include "hal/types/units.hpp"
#include "sim_hal/scenario/scenario.hpp"
#include "tests/support/lift_figures.hpp"
#include "tests/support/thorough.hpp"

using namespace colift;

namespace {

const int kLayouts = tests::thorough() ? 26 : tests::repetitions(10, 3);

struct Limits {
  double lifted, share_within, partner_p90_m;
};

void check(sim_hal::RandomKind kind, int count, const Limits& limits) {
  const auto f = tests::lift_random(kind, control::Method::Fast, 1, count, [](const std::string& said) {
    std::printf("%s\n", said.c_str());
    std::fflush(stdout);
  });
  for (const std::string& why : f.not_lifted) UNSCOPED_INFO(why);
  CHECK(f.lifted >= limits.lifted * f.trials);
  CHECK(f.hit_something == 0);
  CHECK(f.tilt_median_deg <= 1.5);
  CHECK(f.tilt_p95_deg <= 3.0);
  CHECK(f.share_within >= limits.share_within);
  CHECK(f.partner_p90_m <= limits.partner_p90_m);
}

/// On slim stands, lifted at its end; the way home leads past a straight elbow.
sim_hal::Scenario heavy_pipe() {
  sim_hal::Scenario s;
  s.name = "heavy pipe";
  s.object.kind = "cylinder";
  const double radius_m = 0.0426, length_m = 1.209, high_m = 0.314, yaw_deg = 8.37;
  s.object.size = {radius_m, length_m};
  s.object.mass = 3.86;
  s.object.friction = 0.777;
  s.object.xyz = {1.1305, -0.1172, high_m};
  s.object.yaw_deg = yaw_deg;
  const double yaw = hal::deg_to_rad(yaw_deg);
  for (const double along_m : {-0.25 * length_m, 0.25 * length_m}) {
    sim_hal::ScenarioClutter stand;
    stand.shape = "box";
    stand.size = {0.05, 0.08, high_m};
    stand.xyz = {s.object.xyz.x() + along_m * std::cos(yaw), s.object.xyz.y() + along_m * std::sin(yaw), 0.0};
    stand.yaw_deg = yaw_deg;
    s.clutter.push_back(stand);
  }
  s.camera.xyz = s.object.xyz + hal::Vec3(1.0, -1.4, 1.25);
  s.camera.look_at = s.object.xyz + hal::Vec3(0.05, 0.0, 0.05);
  s.partner.grasp = {0.5 * length_m - 0.08, 0.0, 2.0 * radius_m};
  s.partner.arrives_s = 1.0;
  return s;
}

}  // namespace

// aims: 95 % lifted, 90 % within 0.07 of the wanted share, partner within 2 cm at 90 %. Of tables 5 and 20
// the person himself hides his hand: nobody could tell that he holds the table.
TEST_CASE("random tables are lifted level, with the wanted share", "[lifts]") {
  check(sim_hal::RandomKind::Table, kLayouts, {.lifted = 0.92, .share_within = 0.9, .partner_p90_m = 0.02});
}

TEST_CASE("random boxes are lifted level, most with the wanted share", "[lifts]") {
  check(sim_hal::RandomKind::Box, kLayouts, {.lifted = 0.95, .share_within = 0.8, .partner_p90_m = 0.02});
}

// once every fourth pipe ended in a yield: the hand still leaned on it when it opened, and that was the zero
// of what the arm felt on its way home
TEST_CASE("a heavy pipe is lifted, and the arm gets home", "[lifts]") {
  const auto lift = tests::simulate(heavy_pipe(), control::Method::Fast, 3);
  INFO(tests::line("heavy pipe", lift));
  CHECK(lift.record.outcome == control::RunRecord::Result::Lifted);
  CHECK_FALSE(lift.hit_something);
}
