// Beyond the lift: the choice for a task of many poses (thesis 4.2, eq. 4.6 to 4.8).

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "planner/grasp/task_choice.hpp"
#include "tools/experiments/bar_plot.hpp"
#include "tools/experiments/experiment.hpp"
#include "tools/experiments/trials/layouts.hpp"
#include "tools/experiments/trials/sighting.hpp"

namespace colift::experiments {
namespace tasks_trials {
namespace {

using planner::Task;

constexpr double kHeight_m = 0.05;  // of the lift that candidates are judged for
constexpr double kTilt_rad = std::numbers::pi / 3.0;
constexpr double kTurn_rad_s2 = 0.5;
constexpr double kLeg_s = 1.5;

struct NamedTask {
  const char* name;
  Task task;
};

// about the level line between both hands a table is rolled, across it one end goes up a stair
std::vector<NamedTask> tasks(const hal::Vec3& partner, const hal::Vec3& cog) {
  const hal::Vec3 up = hal::Vec3::UnitZ();
  hal::Vec3 along = cog - partner;
  along.z() = 0.0;
  along.normalize();
  const hal::Vec3 across = up.cross(along);
  const std::vector<hal::Vec3> way{{0.0, 0.0, 0.0}, {0.0, 0.8, 0.0}, {0.5, 0.8, 0.0}, {0.5, 0.8, 0.3}};
  std::vector<NamedTask> all{{"lift", planner::lift_task(up)},
                             {"lower", planner::lower_task(up)},
                             {"roll", planner::tilt_task(along, kTilt_rad)},
                             {"pitch", planner::tilt_task(across, kTilt_rad)},
                             {"yaw", planner::yaw_task(up, kTurn_rad_s2)},
                             {"carry", planner::carry_task(way, kLeg_s)}};
  NamedTask whole{"whole", {}};
  for (const NamedTask& t : all) whole.task.insert(whole.task.end(), t.task.begin(), t.task.end());
  all.push_back(std::move(whole));
  return all;
}

// of the box that is seen, filled evenly
planner::CarriedBody body_of(const hal::OrientedBox& box, double mass_kg) {
  const hal::Vec3 s2 = box.size.cwiseProduct(box.size);
  const hal::Vec3 moments = mass_kg / 12.0 * hal::Vec3(s2.y() + s2.z(), s2.x() + s2.z(), s2.x() + s2.y());
  return {mass_kg, box.axes * moments.asDiagonal() * box.axes.transpose()};
}

/// The effort of a grasp in a task, with everything where it truly is.
struct Effort {
  double cost = 0.0;       ///< Eq. 4.6.
  double torque_nm = 0.0;  ///< The largest in either hand, in any pose.
};

Effort effort(const planner::LoadSharing& sharing, const hal::Vec3& partner, const hal::Vec3& robot,
              const std::vector<hal::Wrench>& wrenches) {
  Effort e{sharing.cost(partner, robot, wrenches), 0.0};
  for (const hal::Wrench& w : wrenches) {
    const auto both = sharing.wrenches(partner, robot, w);
    e.torque_nm = std::max({e.torque_nm, both.partner.torque.norm(), both.robot.torque.norm()});
  }
  return e;
}

TrialRows run(const Trial& trial) {
  const sim_hal::Scenario scenario = trial.index % 2 == 0 ? table_layout(trial.index / 2, trial.seed)
                                                          : box_layout(trial.index / 2 + 1, trial.seed);
  const auto refused = [&](const std::string& why) {
    return TrialRows{{scenario.name, cell(scenario.object.mass), "", why}, {}, scenario.name + ": " + why};
  };
  auto observation = Observation::make(scenario, trial.method, trial.own_seed(10), kHeight_m);
  if (!observation) return refused(observation.error().text());
  const control::Config config = config_for(trial.method);
  const auto outcome = (*observation)->decide(config);
  if (!outcome) return refused(outcome.error().text());
  if (!outcome->decision.chosen) return refused(outcome->decision.reason);
  const auto sharing = planner::LoadSharing::create(config.decision.weights);
  if (!sharing) return refused(sharing.error().text());

  const perception::Target& target = *(*observation)->analysis().scene.target;
  const hal::Vec3 up = hal::Vec3::UnitZ(), partner = outcome->partner->position;
  const planner::CarriedBody body = body_of(target.obb, scenario.object.mass);
  const hal::Vec3 true_cog = (*observation)->true_cog(),
                  true_partner = (*observation)->true_partner() - true_cog;
  TrialRows rows;
  std::optional<std::size_t> for_lift;
  std::string said;
  for (const NamedTask& t : tasks(partner, target.cog)) {
    const auto choice = planner::choose_for_task(outcome->candidates, partner, target.cog, up, t.task, body,
                                                 config.decision.weights);
    if (!choice) return refused(choice.error().text());
    if (!choice->best) return refused("no candidate is possible");
    if (!for_lift) for_lift = choice->best;  // the first task
    const auto wrenches = planner::task_wrenches(t.task, body, up);
    const auto of = [&](std::size_t i) {
      return effort(*sharing, true_partner, planner::load_point(outcome->candidates[i]) - true_cog, wrenches);
    };
    const Effort lift = of(*for_lift), task = of(*choice->best);
    const double saved = 1.0 - task.cost / lift.cost;
    rows.details.push_back({t.name, cell(outcome->candidates[*for_lift].id),
                            cell(outcome->candidates[*choice->best].id), cell(saved), cell(lift.torque_nm),
                            cell(task.torque_nm)});
    if (std::string_view(t.name) == "whole") said = fmt::format("{:.1f} % of the effort saved", 1e2 * saved);
  }
  rows.row = {scenario.name, cell(scenario.object.mass), cell(static_cast<int>(outcome->candidates.size())),
              ""};
  rows.words = fmt::format("{}: the whole task: {}", scenario.name, said);
  return rows;
}

std::vector<Figure> figures(const Results& r) {
  std::vector<Figure> out;
  for (const char* name : {"lower", "roll", "pitch", "yaw", "carry", "whole"}) {
    std::vector<double> saved, lift_nm, task_nm;
    int n = 0, differ = 0;
    for (const Row& d : r.details.rows()) {
      if (r.details.text(d, "task") != name) continue;
      ++n;
      differ += r.details.text(d, "lift_id") != r.details.text(d, "task_id");
      saved.push_back(r.details.number(d, "saved"));
      lift_nm.push_back(r.details.number(d, "lift_choice_nm"));
      task_nm.push_back(r.details.number(d, "task_choice_nm"));
    }
    const std::string key = name;
    out.push_back({"differ_" + key, key + ": the task is given another grasp than the lift alone",
                   rate(differ, n), "%"});
    Figure mean{"saved_" + key, key + ": effort saved by the choice for the task, mean", mean_estimate(saved),
                "%"};
    if (key == "roll" || key == "whole") mean.goal = 0.0;
    out.push_back(std::move(mean));
    out.push_back({"torque_lift_" + key, key + ": largest torque in a hand, choice for the lift, 95 % below",
                   quantile_estimate(lift_nm, 0.95), "N m"});
    out.push_back({"torque_task_" + key, key + ": the same, choice for the task, 95 % below",
                   quantile_estimate(task_nm, 0.95), "N m"});
  }
  return out;
}

picture::Canvas plot(const Results& r) {
  BarPanel saved{"Effort saved by the choice for the task, mean (%)", {}, {}, {}};
  BarPanel lift{"Largest torque in a hand, choice for the lift (N m)", {}, {}, {}};
  BarPanel task{"Largest torque in a hand, choice for the task (N m)", {}, {}, {}};
  for (const Figure& f : figures(r)) {
    BarPanel* panel = f.key.starts_with("saved_")         ? &saved
                      : f.key.starts_with("torque_lift_") ? &lift
                      : f.key.starts_with("torque_task_") ? &task
                                                          : nullptr;
    if (panel == nullptr) continue;
    const double scale = panel == &saved ? 100.0 : 1.0;
    panel->bars.push_back({f.key.substr(f.key.rfind('_') + 1), scale * f.estimate.value, false,
                           scale * f.estimate.low, scale * f.estimate.high});
  }
  return draw_bar_plot({saved, lift, task});
}

}  // namespace
}  // namespace tasks_trials

Experiment tasks_experiment() {
  using namespace tasks_trials;
  Experiment e;
  e.name = "tasks";
  e.title = "The choice for a task of many poses";
  e.thesis = "4.2, eq. 4.6 to 4.8";
  e.question =
      "A table (even trials) or a box (odd ones) and a partner. For lowering, rolling and pitching by 60 "
      "degrees, turning, carrying through waypoints, and all of it, the grasp is chosen for the task and for "
      "the lift alone, on what was seen; the effort of both in the task is computed with the true centre of "
      "gravity and the true place of the partner.";
  e.default_trials = 100;
  e.columns = {"layout", "mass_kg", "candidates", "because"};
  e.detail_columns = {"task", "lift_id", "task_id", "saved", "lift_choice_nm", "task_choice_nm"};
  e.run = run;
  e.figures = figures;
  e.plot = plot;
  return e;
}

}  // namespace colift::experiments
