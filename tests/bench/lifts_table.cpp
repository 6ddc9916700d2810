// Whole lifts of random tables and boxes, and of the shipped scenarios, with both methods side by side, as
// tables: lifts_table [COUNT [FIRST_SEED]]. Each random lift is a line on stderr. Where the thesis's method
// does not lift, the table says why. lifts_table fast|thesis FILE... runs scenario files
// with every change of state.

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "tests/support/lift_figures.hpp"

using namespace colift;

namespace {

constexpr control::Method kMethods[] = {control::Method::Fast, control::Method::Thesis};

const char* word(control::Method method) {
  return control::to_string(method);
}

const char* word(control::RunRecord::Result outcome) {
  using Result = control::RunRecord::Result;
  return outcome == Result::Lifted ? "lifted" : outcome == Result::Aborted ? "aborted" : "refused";
}

/// A sentence without what differs from seed to seed, so that like ones can be counted.
std::string kind_of(const std::string& reason) {
  std::string out;
  for (const char c : reason) {
    if (c >= '0' && c <= '9') {
      if (out.empty() || out.back() != '#') out += '#';
    } else if (!(c == '.' && !out.empty() && out.back() == '#')) {
      out += c == '|' ? '/' : c;
    }
  }
  return out;
}

std::string share_text(const tests::SimulatedLift& lift) {
  if (lift.record.outcome != control::RunRecord::Result::Lifted)
    return fmt::format("{}: {}", word(lift.record.outcome), lift.record.reason);
  return fmt::format("lifted, tilt {:.2f} deg, share {:.2f}, partner {:.0f} mm", lift.tilt_deg,
                     lift.share_robot, 1e3 * lift.partner_error_m);
}

void random_lifts(int count, std::uint64_t first) {
  fmt::print(
      "| {} lifts each | lifted | tilt median | tilt 95 % | share within 0.07 of 0.5 | partner 90 % | slip "
      "95 % | "
      "times real time |\n| --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: |\n",
      count);
  struct Row {
    const char* what;
    sim_hal::RandomKind kind;
    std::function<void(sim_hal::Scenario&)> arrange;
  };
  const Row rows[] = {
      {"tables", sim_hal::RandomKind::Table, {}},
      {"tables, seen from beside the robot", sim_hal::RandomKind::Table, tests::see_from_beside_robot},
      {"boxes", sim_hal::RandomKind::Box, {}}};
  std::map<std::string, int> reasons;  // of what the thesis's method did not lift
  for (const auto& [what, kind, arrange] : rows) {
    for (const auto method : kMethods) {
      const auto f = tests::lift_random(
          kind, method, first, count,
          [method](const std::string& said) { std::fprintf(stderr, "%s: %s\n", word(method), said.c_str()); },
          arrange);
      if (f.lifted > 0) {
        fmt::print("| {}, {} | {} | {:.2f} deg | {:.2f} deg | {:.0f} % | {:.1f} mm | {:.1f} mm | {:.1f} |\n",
                   what, word(method), f.lifted, f.tilt_median_deg, f.tilt_p95_deg, 100 * f.share_within,
                   1e3 * f.partner_p90_m, 1e3 * f.slip_p95_m, f.real_time);
      } else {
        fmt::print("| {}, {} | 0 | | | | | | {:.1f} |\n", what, word(method), f.real_time);
      }
      if (method != control::Method::Thesis) continue;
      for (const std::string& said : f.not_lifted) {
        const std::size_t name_end = said.find(": ");
        ++reasons[kind_of(fmt::format("{}: {}", what, said.substr(name_end + 2)))];
      }
    }
  }
  if (reasons.empty()) return;
  fmt::print("\n| thesis, not lifted | times |\n| --- | ---: |\n");
  for (const auto& [reason, times] : reasons) fmt::print("| {} | {} |\n", reason, times);
}

void shipped_scenarios() {
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(COLIFT_SCENARIOS))
    if (entry.path().extension() == ".yaml") files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  fmt::print("\n| shipped scenario, seed 1 | fast | thesis |\n| --- | --- | --- |\n");
  for (const auto& file : files) {
    const auto scenario = sim_hal::load_scenario(file.string());
    if (!scenario) {
      fmt::print("| {} | not read: {} | |\n", file.stem().string(), scenario.error().text());
      continue;
    }
    std::string row = fmt::format("| {} |", file.stem().string());
    for (const auto method : kMethods)
      row += fmt::format(" {} |", share_text(tests::simulate(*scenario, method, 1)));
    fmt::print("{}\n", row);
    std::fflush(stdout);
  }
}

void told_in_full(const char* file, control::Method method) {
  const auto scenario = sim_hal::load_scenario(file);
  if (!scenario) {
    fmt::print("{}\n", scenario.error().text());
    return;
  }
  const auto lift = tests::simulate(*scenario, method, 1);
  fmt::print("{}\n", tests::line(fmt::format("{}, {}", scenario->name, word(method)), lift));
  for (const auto& s : lift.record.states)
    fmt::print("  {:6.2f} s  {:13} {}\n", hal::seconds(s.at), control::word(s.state), s.reason);
  std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) {
  for (const auto method : kMethods) {
    if (argc < 3 || std::string(argv[1]) != word(method)) continue;
    for (int i = 2; i < argc; ++i) told_in_full(argv[i], method);
    return 0;
  }
  const int count = argc > 1 ? std::atoi(argv[1]) : 25;
  const auto first = static_cast<std::uint64_t>(argc > 2 ? std::atoi(argv[2]) : 1);
  random_lifts(count, first);
  shipped_scenarios();
}
