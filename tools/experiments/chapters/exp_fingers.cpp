// Beyond the thesis: something as thick as a finger between the hand's fingers and the object.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "hal/types/units.hpp"
#include "planner/hand/hand_model.hpp"
#include "sim_hal/synthetic/hash_random.hpp"
#include "tools/experiments/bar_plot.hpp"
#include "tools/experiments/experiment.hpp"
#include "tools/experiments/runs/whole_lift.hpp"
#include "tools/experiments/trials/layouts.hpp"

namespace colift::experiments {
namespace fingers_trials {
namespace {

using control::Task;

constexpr double kThick_m = 0.020, kLong_m = 0.050;
constexpr double kOff_m = 0.001;     // from the object's face
constexpr double kAside_m = 0.0375;  // of a thing under F1 or F2 alone: its end is beside the other one
constexpr double kComesFrom_m = 1.5, kComes_m_s = 3.0, kComesBefore_s = 0.25;
constexpr double kLevel = 0.3, kUpright = 0.95;  // vertical part of a unit vector: at most, at least
constexpr double kSameGrasp_m = 0.002;
enum Place { kF1, kF2, kF1AndF2, kF3 };
constexpr const char* kPlaces[] = {"F1", "F2", "F1 and F2", "F3"};

/// Where the fingers of a run closed first, and what came of it.
struct Grip {
  std::optional<planner::GraspCandidate> grasp;
  double close_s = NAN;
  bool accepted = false;  ///< The hand kept it, and waited for the partner.
  std::string why;        ///< It did not.
};

Grip grip_of(const control::RunRecord& record) {
  Grip grip;
  bool closed = false;
  for (const control::StateChange& s : record.states) {
    if (s.state == Task::Close && !closed) {
      closed = true;
      grip.close_s = hal::seconds(s.at);
    } else if (closed && s.state != Task::Verify) {
      grip.accepted = s.state == Task::AwaitReady;
      grip.why = s.reason;
      break;
    }
  }
  const auto& decision = record.decision;
  if (closed && decision && decision->decision.chosen)
    grip.grasp = decision->candidates[static_cast<std::size_t>(*decision->decision.chosen)];
  return grip;
}

/// On the object's face under the pads, and held there from elsewhere: along the palm's width, or, under
/// level fingers that come from above, upright under one of them. nullopt where no piece of clutter can lie
/// so: fingers that close at a slant, or two that one upright thing would have to be under.
std::optional<sim_hal::ScenarioClutter> thing_between(const planner::GraspCandidate& grasp,
                                                      const planner::HandModel& hand, Place place,
                                                      double close_s) {
  const hal::Vec3 across = grasp.closing.cross(grasp.approach);
  const bool upright = std::abs(across.z()) > kUpright, level = std::abs(grasp.closing.z()) < kLevel;
  const bool flat = std::abs(grasp.closing.z()) > kUpright && std::abs(across.z()) < kLevel;
  if (!upright && !level && !flat) return std::nullopt;
  const bool stands = !upright && level;
  if (stands && place == kF1AndF2) return std::nullopt;
  const double x_m = place == kF1 || place == kF2 ? hand.fingers[place].x_m : 0.0;
  const double aside_m = stands || x_m == 0.0 ? x_m : std::copysign(kAside_m, x_m);
  const double side = place == kF3 ? 1.0 : -1.0;
  const hal::Vec3 middle = planner::load_point(grasp) + aside_m * across +
                           side * (0.5 * (grasp.width + kThick_m) + kOff_m) * grasp.closing;
  sim_hal::ScenarioClutter thing;
  double height_m = kThick_m;
  if (flat) {
    thing.size = {kLong_m, kThick_m, kThick_m};
    thing.yaw_deg = hal::rad_to_deg(std::atan2(across.y(), across.x()));
  } else {
    height_m = stands ? 2.0 * kThick_m : kLong_m;
    thing.shape = "cylinder";
    thing.size = {0.5 * kThick_m, height_m};
  }
  const hal::Vec3 to = middle - 0.5 * height_m * hal::Vec3::UnitZ();
  // from above, or from the side on which it ends up
  const bool down = upright ? across.z() < 0.0 : aside_m < 0.0;
  thing.xyz = to + (down ? -kComesFrom_m : kComesFrom_m) * across;
  thing.moves = {{close_s - kComesBefore_s, to, kComes_m_s}};
  return thing;
}

TrialRows run(const Trial& trial) {
  const std::uint64_t seed = trial.own_seed(51);
  sim_hal::Draws draws(seed, 9100);
  const auto place = static_cast<Place>(std::min(static_cast<int>(4.0 * draws.between(0.0, 1.0)), 3));
  sim_hal::Scenario scenario = mixed_layout(trial.index, trial.seed);
  const std::string& object = scenario.object.kind;
  const auto without = [&](const std::string& why) {
    return TrialRows{{object, kPlaces[place], "", "", "", "", why}, {}, object + ": " + why};
  };
  LiftHooks hooks;
  hooks.cut.at = {Task::AwaitReady, Task::Release};
  const auto nominal = run_whole_lift(scenario, trial.method, seed, hooks);
  if (!nominal) return without(nominal.error().text());
  const Grip alone = grip_of(nominal->record);
  if (!alone.grasp) return without("no grip: " + nominal->record.reason);
  const auto thing = thing_between(*alone.grasp, shared_hand(trial.method).hand, place, alone.close_s);
  if (!thing) return without("no such thing can lie there");
  scenario.clutter.push_back(*thing);
  const auto lift = run_whole_lift(scenario, trial.method, seed, hooks);
  if (!lift) return without(lift.error().text());
  const Grip grip = grip_of(lift->record);
  if (!grip.grasp || (grip.grasp->position - alone.grasp->position).norm() > kSameGrasp_m)
    return without("with the thing another grasp was chosen: " + lift->record.reason);
  const bool wraps = grip.grasp->kind == planner::GraspKind::Wrap;
  TrialRows rows;
  rows.row = {object,
              kPlaces[place],
              wraps ? "wrap" : "pinch",
              cell(1e3 * grip.grasp->width),
              cell(!grip.accepted),
              cell(!alone.accepted),
              grip.accepted ? "" : grip.why};
  if (grip.accepted) rows.kept = KeptLift{scenario, seed};
  rows.words = fmt::format("{}, under {}: {}{}", object, kPlaces[place],
                           grip.accepted ? "NOT FOUND" : "found: " + grip.why,
                           alone.accepted ? "" : "; without it, too: " + alone.why);
  return rows;
}

std::vector<Figure> figures(const Results& r) {
  int n = 0, found = 0, named = 0, false_alarms = 0, pinches = 0, pinches_found = 0;
  for (const Row& row : r.trials.rows()) {
    if (r.trials.text(row, "found").empty()) continue;
    ++n;
    const bool is_found = r.trials.number(row, "found") > 0.5;
    found += is_found;
    named += r.trials.text(row, "because").find("between") != std::string::npos;
    false_alarms += r.trials.number(row, "without_too") > 0.5;
    if (r.trials.text(row, "grip") != "pinch") continue;
    ++pinches;
    pinches_found += is_found;
  }
  return {{"found", "a thing of 20 mm is not gripped with the object", rate(found, n), "%", 0.95, true},
          {"found_pinch", "of grips between pads", rate(pinches_found, pinches), "%"},
          {"named", "and said to be between fingers and object", rate(named, found), "%"},
          {"without", "grips that are refused without it, too", rate(false_alarms, n), "%"}};
}

picture::Canvas plot(const Results& r) {
  BarPanel panel{"Found (%)", {}, {}, {}};
  for (const char* kind : {"table", "box", "cylinder", "chair"}) {
    int n = 0, found = 0;
    for (const Row& row : r.trials.rows()) {
      if (r.trials.text(row, "object") != kind || r.trials.text(row, "found").empty()) continue;
      ++n;
      found += r.trials.number(row, "found") > 0.5;
    }
    if (n > 0) panel.bars.push_back({kind, 100.0 * found / n});
  }
  return draw_bar_plot({panel});
}

}  // namespace
}  // namespace fingers_trials

Experiment fingers_experiment() {
  using namespace fingers_trials;
  Experiment e;
  e.name = "fingers";
  e.title = "A finger between the hand and the object";
  e.thesis = "beyond it";
  e.question =
      "The hand closes on tables, boxes, pipes and chairs, each once as it is and once with a rod of 20 mm "
      "on the object under one or two of its fingers. Does it open again?";
  e.default_trials = 200;
  e.columns = {"object", "place", "grip", "width_mm", "found", "without_too", "because"};
  e.run = run;
  e.figures = figures;
  e.plot = plot;
  return e;
}

}  // namespace colift::experiments
