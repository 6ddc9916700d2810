// Simulated calibrations as a table, over the number of poses and the noise: calibration_table [RUNS
// [RUNS_OF_THE_OTHER_LINES]]. The tables of docs/calibration.md are its output.

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <string>
#include <vector>

#include "tests/support/calibration_trial.hpp"

using namespace colift;
using tests::TrialSetting;

namespace {

void line(const char* name, const TrialSetting& setting, int runs) {
  perception::CalibrationConfig config;
  config.arm_m = std::max(setting.arm_m, 1e-4);
  config.pixel_px = std::max(setting.pixel_px, 0.05);
  std::vector<double> errors;
  std::map<std::string, int> refused;
  double predicted = 0.0;
  for (int run = 1; run <= runs; ++run) {
    const auto trial = tests::make_trial(setting, static_cast<std::uint64_t>(run));
    const auto c =
        perception::calibrate(trial.samples, trial.camera, config, static_cast<std::uint64_t>(run));
    if (!c) {
      ++refused[c.error().kind];
      continue;
    }
    errors.push_back(1e3 * trial.error_m(c->model.X_BC(), config));
    predicted += 1e3 * c->error_m;
  }
  std::string reasons;
  for (const auto& [kind, count] : refused)
    reasons += fmt::format("{}{} {}", reasons.empty() ? "" : ", ", count, kind);
  if (errors.empty()) {
    fmt::print("| {} | {} | 0 | | | | | 0 | {} |\n", name, runs, reasons);
    std::fflush(stdout);
    return;
  }
  std::sort(errors.begin(), errors.end());
  const auto worse = std::count_if(errors.begin(), errors.end(), [](double e) { return e > 8.0; });
  fmt::print("| {} | {} | {} | {:.1f} | {:.1f} | {:.1f} | {:.1f} | {} | {} |\n", name, runs, errors.size(),
             errors[errors.size() / 2], errors[std::min(errors.size() - 1, errors.size() * 95 / 100)],
             errors.back(), predicted / static_cast<double>(errors.size()), worse, reasons);
  std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) {
  const int runs = argc > 1 ? std::atoi(argv[1]) : 200;
  const int others = argc > 2 ? std::atoi(argv[2]) : 60;
  fmt::print(
      "| setting | runs | accepted | median (mm) | 95 % | worst | predicted | worse than 8 mm | refused |\n"
      "| --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: | --- |\n");
  line("20 poses, 0.3 px, 1 mm", {}, runs);
  line("20 poses at random, 35 deg", {.chosen = false}, runs);
  line("12 poses", {.poses = 12}, others);
  line("15 poses", {.poses = 15}, others);
  line("30 poses", {.poses = 30}, others);
  line("20 poses, with depth", {.depth = true}, others);
  line("arm 0.5 mm", {.arm_m = 0.0005}, others);
  line("arm 2 mm", {.arm_m = 0.002}, others);
  line("arm 3 mm", {.arm_m = 0.003}, others);
  line("spots 0.1 px", {.pixel_px = 0.1}, others);
  line("spots 1 px", {.pixel_px = 1.0}, others);
  line("25 poses, 20 % wrong spots", {.poses = 25, .outliers = 0.2}, others);
  line("random, 60 deg", {.chosen = false, .rotation_deg = 60}, others);
  line("random, 20 deg", {.chosen = false, .rotation_deg = 20}, others);
  line("random, 10 deg", {.chosen = false, .rotation_deg = 10}, others);
}
