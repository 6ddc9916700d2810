// Perception in rooms that nobody tuned it for: which object is the target, and is it one.

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "tools/experiments/experiment.hpp"
#include "tools/experiments/trials/seen_room.hpp"
#include "tools/visualization/palette.hpp"

namespace colift::experiments {
namespace rooms_trials {
namespace {

// of the contact sheet
constexpr int kThumbWidth = 320, kThumbHeight = 240, kCaption = 34, kColumns = 4, kRows = 4;

std::string class_of(const SeenRoom& seen) {
  if (!seen.room.has_object) return "empty";
  return seen.solvable() ? "solvable" : "hard";
}

TrialRows run(const Trial& trial) {
  const std::uint64_t seed = trial.own_seed(31);
  const SeenRoom seen = see_room(seed, trial.method);
  const auto& target = seen.analysis.scene.target;
  TrialRows rows;
  rows.row = {std::to_string(seed),    std::string(sim_hal::name_of(seen.room.sensor)),
              class_of(seen),          cell(seen.room.has_person),
              word(seen.verdict),      cell(seen.analysis.scene.ground.has_value()),
              cell(seen.ground_right), cell(target ? target->confidence : NAN),
              seen.room.name,          seen.analysis.scene.reason};
  rows.words = fmt::format("{}: {} ({})", seen.room.name, word(seen.verdict), class_of(seen));
  return rows;
}

Estimate share_of(const Results& r, const std::string& kind, const std::vector<std::string>& verdicts) {
  int all = 0, hits = 0;
  for (const Row& row : r.trials.rows()) {
    if (!kind.empty() && r.trials.text(row, "class") != kind) continue;
    ++all;
    hits += std::count(verdicts.begin(), verdicts.end(), r.trials.text(row, "verdict")) > 0 ? 1 : 0;
  }
  return rate(hits, all);
}

std::vector<Figure> figures(const Results& r) {
  int grounds = 0, right_grounds = 0;
  for (const Row& row : r.trials.rows()) {
    grounds += r.trials.number(row, "ground") > 0.5;
    right_grounds += r.trials.number(row, "ground_right") > 0.5;
  }
  return {{"right", "the object, of those that a person would point at", share_of(r, "solvable", {"right"}),
           "%", 0.8},
          {"partly", "a part of it, or more than it", share_of(r, "solvable", {"partly"}), "%"},
          {"nothing", "nothing found, with a reason", share_of(r, "solvable", {"nothing"}), "%"},
          {"wrong", "something else as the target, of all rooms", share_of(r, "", {"wrong", "person"}), "%",
           0.1, false},
          {"person", "a person as the target, of all rooms", share_of(r, "", {"person"}), "%", 0.0, false},
          {"empty", "no target where there is no object", share_of(r, "empty", {"nothing"}), "%"},
          {"ground", "ground right, of those that were found", rate(right_grounds, grounds), "%"}};
}

// depth in grey, the truth's object bluish, persons reddish, what was taken as the target green
std::vector<std::uint8_t> thumbnail(const SeenRoom& seen) {
  const perception::OrganisedCloud& cloud = seen.analysis.cloud;
  std::vector<bool> taken(cloud.size(), false);
  if (seen.analysis.scene.target) {
    for (const Eigen::Vector3f& p : seen.analysis.scene.target->points) {
      const auto at = cloud.project(p.cast<double>());
      if (cloud.contains(at.u, at.v))
        taken[static_cast<std::size_t>(std::lround(at.v)) * static_cast<std::size_t>(cloud.width()) +
              static_cast<std::size_t>(std::lround(at.u))] = true;
    }
  }
  std::vector<std::uint8_t> rgb;
  rgb.reserve(3 * kThumbWidth * kThumbHeight);
  for (int y = 0; y < kThumbHeight; ++y) {
    for (int x = 0; x < kThumbWidth; ++x) {
      const auto i = static_cast<std::size_t>(y * cloud.height() / kThumbHeight) *
                         static_cast<std::size_t>(cloud.width()) +
                     static_cast<std::size_t>(x * cloud.width() / kThumbWidth);
      auto c = picture::depth_rgb(static_cast<double>(cloud.depth_m[i]));
      if (cloud.seen(i)) {
        if (seen.truth.label[i] == sim_hal::Label::Target) c[2] = std::min(255.0, c[2] + 90);
        if (seen.truth.label[i] == sim_hal::Label::Partner) c[0] = std::min(255.0, c[0] + 90);
        if (taken[i]) c[1] = 220;
      }
      for (const double v : c) rgb.push_back(static_cast<std::uint8_t>(v));
    }
  }
  return rgb;
}

// contact sheet: the wrong ones first, then what was missed
picture::Canvas plot(const Results& r) {
  picture::Canvas canvas(kColumns * kThumbWidth, kRows * (kThumbHeight + kCaption), picture::kPaper);
  int k = 0;
  const auto method = [&](const Row& row) {
    return r.trials.text(row, "method") == "thesis" ? control::Method::Thesis : control::Method::Fast;
  };
  for (const char* verdict : {"person", "wrong", "partly", "nothing", "right"}) {
    for (const Row& row : r.trials.rows()) {
      if (k == kColumns * kRows) return canvas;
      if (r.trials.text(row, "verdict") != verdict) continue;
      if (verdict == std::string("nothing") && r.trials.text(row, "class") != "solvable") continue;
      const SeenRoom seen = see_room(std::stoull(r.trials.text(row, "seed")), method(row));
      const int x = k % kColumns * kThumbWidth, y = k / kColumns * (kThumbHeight + kCaption);
      canvas.image(x, y, kThumbWidth, kThumbHeight, thumbnail(seen));
      picture::TextStyle small;
      small.size = 11.0;
      const picture::Canvas::Clip clip(canvas, {static_cast<double>(x), static_cast<double>(y),
                                                kThumbWidth - 4.0, kThumbHeight + kCaption + 0.0});
      canvas.text({x + 3.0, y + kThumbHeight + 13.0},
                  fmt::format("{}: {}, {}", TrialTable::trial_of(row), verdict, r.trials.text(row, "class")),
                  small);
      canvas.text({x + 3.0, y + kThumbHeight + 27.0}, r.trials.text(row, "room"), small);
      ++k;
    }
  }
  return canvas;
}

}  // namespace
}  // namespace rooms_trials

Experiment rooms_experiment() {
  using namespace rooms_trials;
  Experiment e;
  e.name = "rooms";
  e.title = "Any room: is the target the object?";
  e.thesis = "beyond it";
  e.question =
      "A random room (walls, doors, windows, cupboards, sofas, stairs, small things, persons; four kinds of "
      "depth cameras at any height, rolled) is seen once, without gravity or pose; the target is compared "
      "with the truth of every pixel. The picture shows the failures.";
  e.default_trials = 200;
  e.columns = {"seed",   "sensor",       "class",      "has_person", "verdict",
               "ground", "ground_right", "confidence", "room",       "because"};
  e.run = run;
  e.trials_set = "what colift look has as defaults: check --for look";
  e.figures = figures;
  e.plot = plot;
  return e;
}

}  // namespace colift::experiments
