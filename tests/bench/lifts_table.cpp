// Whole lifts of random tables and boxes with both methods, as a table: lifts_table [COUNT [FIRST_SEED]].
// Each lift is a line on stderr.

#include <fmt/format.h>

#include <cstdio>
#include <cstdlib>

#include "tests/support/lift_figures.hpp"

using namespace colift;

int main(int argc, char** argv) {
  const int count = argc > 1 ? std::atoi(argv[1]) : 25;
  const auto first = static_cast<std::uint64_t>(argc > 2 ? std::atoi(argv[2]) : 1);
  fmt::print(
      "| {} lifts each | lifted | tilt median | tilt 95 % | share within 0.07 of 0.5 | partner 90 % | slip "
      "95 % | "
      "times real time |\n| --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: |\n",
      count);
  for (const auto kind : {sim_hal::RandomKind::Table, sim_hal::RandomKind::Box}) {
    for (const auto method : {control::Method::Fast, control::Method::Thesis}) {
      const auto f = tests::lift_random(kind, method, first, count, [](const std::string& said) {
        std::fprintf(stderr, "%s\n", said.c_str());
      });
      fmt::print("| {}, {} | {} | {:.2f} deg | {:.2f} deg | {:.0f} % | {:.1f} mm | {:.1f} mm | {:.1f} |\n",
                 kind == sim_hal::RandomKind::Table ? "tables" : "boxes",
                 method == control::Method::Fast ? "fast" : "thesis", f.lifted, f.tilt_median_deg,
                 f.tilt_p95_deg, 100 * f.share_within, 1e3 * f.partner_p90_m, 1e3 * f.slip_p95_m,
                 f.real_time);
    }
  }
}
