// Somebody is in the room when the robot looks at it: a person is not what is to be carried.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "tools/experiments/experiment.hpp"
#include "tools/experiments/trials/room_sheet.hpp"
#include "tools/experiments/trials/seen_room.hpp"

namespace colift::experiments {
namespace stances_trials {
namespace {

TrialRows run(const Trial& trial) {
  const std::uint64_t seed = trial.own_seed(33);
  const SeenRoom seen = see_room(sim_hal::make_occupied_room(seed), seed, trial.method);
  const auto& target = seen.analysis.scene.target;
  TrialRows rows;
  rows.row = {std::to_string(seed),
              seen.room.stance ? std::string(sim_hal::word(*seen.room.stance)) : "nobody",
              std::string(sim_hal::name_of(seen.room.sensor)),
              cell(static_cast<double>(seen.person_pixels)),
              seen.object_class(),
              word(seen.verdict),
              cell(target ? target->confidence : NAN),
              seen.room.name,
              seen.analysis.scene.reason};
  rows.words = fmt::format("{}: {} ({})", seen.room.name, word(seen.verdict), seen.object_class());
  return rows;
}

std::vector<Figure> figures(const Results& r) {
  std::vector<Figure> out{{"person", "a person as the target, of all rooms",
                           verdict_share(r, "stance", "", {"person"}), "%", 0.0, false},
                          {"right", "the object, of those that a person would point at",
                           verdict_share(r, "class", "solvable", {"right"}), "%"}};
  for (const sim_hal::Stance stance : sim_hal::kStances) {
    const std::string name(sim_hal::word(stance));
    std::string key = "person_" + name;
    std::replace(key.begin(), key.end(), ' ', '_');
    out.push_back({key, "somebody " + name + " as the target", verdict_share(r, "stance", name, {"person"}),
                   "%", 0.0, false});
  }
  return out;
}

}  // namespace
}  // namespace stances_trials

Experiment stances_experiment() {
  using namespace stances_trials;
  Experiment e;
  e.name = "stances";
  e.title = "Somebody is in the room: is a person ever the target?";
  e.thesis = "beyond it";
  e.question =
      "A random room as in `rooms`, always with a person who stands, stoops, sits on the floor, crouches, "
      "kneels, is on "
      "all fours or lies, joint angles and height drawn; every other camera looks at him. The picture shows "
      "the failures.";
  e.default_trials = 200;
  e.columns = {"seed",    "stance",     "sensor", "person_pixels", "class",
               "verdict", "confidence", "room",   "because"};
  e.run = run;
  e.trials_set = "what colift look has as defaults: check --for look";
  e.figures = figures;
  e.plot = [](const Results& r) { return room_sheet(r, sim_hal::make_occupied_room); };
  return e;
}

}  // namespace colift::experiments
