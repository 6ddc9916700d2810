// Perception in rooms that nobody tuned it for: which object is the target, and is it one.

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "tools/experiments/experiment.hpp"
#include "tools/experiments/trials/room_sheet.hpp"
#include "tools/experiments/trials/seen_room.hpp"

namespace colift::experiments {
namespace rooms_trials {
namespace {

TrialRows run(const Trial& trial) {
  const std::uint64_t seed = trial.own_seed(31);
  const SeenRoom seen = see_room(sim_hal::make_room(seed), seed, trial.method);
  const auto& target = seen.analysis.scene.target;
  TrialRows rows;
  rows.row = {std::to_string(seed),    std::string(sim_hal::name_of(seen.room.sensor)),
              seen.object_class(),     cell(seen.room.has_person),
              word(seen.verdict),      cell(seen.analysis.scene.ground.has_value()),
              cell(seen.ground_right), cell(target ? target->confidence : NAN),
              seen.room.name,          seen.analysis.scene.reason};
  rows.words = fmt::format("{}: {} ({})", seen.room.name, word(seen.verdict), seen.object_class());
  return rows;
}

std::vector<Figure> figures(const Results& r) {
  int grounds = 0, right_grounds = 0;
  for (const Row& row : r.trials.rows()) {
    grounds += r.trials.number(row, "ground") > 0.5;
    right_grounds += r.trials.number(row, "ground_right") > 0.5;
  }
  return {
      {"right", "the object, of those that a person would point at",
       verdict_share(r, "class", "solvable", {"right"}), "%", 0.8},
      {"partly", "a part of it, or more than it", verdict_share(r, "class", "solvable", {"partly"}), "%"},
      {"nothing", "nothing found, with a reason", verdict_share(r, "class", "solvable", {"nothing"}), "%"},
      {"wrong", "something else as the target, of all rooms",
       verdict_share(r, "class", "", {"wrong", "person"}), "%", 0.1, false},
      {"person", "a person as the target, of all rooms", verdict_share(r, "class", "", {"person"}), "%", 0.0,
       false},
      {"empty", "no target where there is no object", verdict_share(r, "class", "empty", {"nothing"}), "%"},
      {"ground", "ground right, of those that were found", rate(right_grounds, grounds), "%"}};
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
  e.plot = [](const Results& r) { return room_sheet(r, sim_hal::make_room); };
  return e;
}

}  // namespace colift::experiments
