// Figures over random lifts. Limits follow the aims of the project; where one is not reached yet, the limit
// says so.

#include <catch2/catch.hpp>
#include <cstdio>

#include "tests/support/lift_figures.hpp"
#include "tests/support/thorough.hpp"

using namespace colift;

namespace {

const int kLayouts = tests::thorough() ? 26 : tests::repetitions(16, 3);

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

}  // namespace

// aims: 95 % lifted, 90 % within 0.07 of the wanted share, partner within 2 cm at 90 %. Of tables 5 and 20
// the person himself hides his hand: nobody could tell that he holds the table.
TEST_CASE("random tables are lifted level, with the wanted share", "[lifts]") {
  check(sim_hal::RandomKind::Table, kLayouts, {.lifted = 0.92, .share_within = 0.9, .partner_p90_m = 0.02});
}

TEST_CASE("random boxes are lifted level, most with the wanted share", "[lifts]") {
  check(sim_hal::RandomKind::Box, kLayouts, {.lifted = 0.95, .share_within = 0.8, .partner_p90_m = 0.02});
}
