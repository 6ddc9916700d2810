// Beyond the thesis: a camera behind the partner never sees his hand. Is it known that he holds the object,
// and is nobody taken for a partner who only stands there?

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "sim_hal/synthetic/hash_random.hpp"
#include "tools/experiments/bar_plot.hpp"
#include "tools/experiments/experiment.hpp"
#include "tools/experiments/runs/whole_lift.hpp"
#include "tools/experiments/trials/layouts.hpp"

namespace colift::experiments {
namespace hidden_hand_trials {
namespace {

using control::Task;
using hal::Vec3;

constexpr double kHeight_m = 0.05, kHold_s = 1.0;
constexpr double kComes_s = 3.0;       // after the scene was learnt
constexpr double kRaises_s = 5.0;      // after he took hold: he has been asked to
constexpr double kWrong_mm = 100.0;    // more than a hand is wide: it is seen where it is not
constexpr double kNinetyFive = 7.815;  // quantile of chi square, three degrees of freedom

control::TaskSaid task() {
  return {"experiment hidden-hand", kHeight_m, kHold_s};
}

/// What somebody does between the camera and the object.
enum class Does { Raises, Stands, Touches };

constexpr const char* word(Does does) {
  switch (does) {
    case Does::Raises:
      return "raises";
    case Does::Stands:
      return "stands";
    default:
      return "touches";
  }
}

Does drawn(int index) {
  constexpr Does kInTurn[] = {Does::Raises, Does::Raises, Does::Raises,
                              Does::Stands, Does::Raises, Does::Touches};
  return kInTurn[index % 6];
}

// Random tables and boxes, the camera on the partner's side of them, behind his back.
sim_hal::Scenario layout(int index, std::uint64_t seed, sim_hal::Draws& draws) {
  const int i = 2 + index / 2;                      // the first two are shipped scenes
  const bool table = (index + index / 6) % 2 == 0;  // six: each does everything with both
  sim_hal::Scenario s = table ? table_layout(i, seed) : box_layout(i, seed);
  const sim_hal::Pose X_WT = sim_hal::object_pose(s.object);
  const Vec3 grasp_W = X_WT * s.partner.grasp;
  Vec3 out = grasp_W - X_WT.translation();
  out.z() = 0.0;
  out.normalize();
  const Vec3 aside(-out.y(), out.x(), 0.0);
  s.camera.xyz = grasp_W + draws.between(1.1, 1.5) * out + draws.between(-0.25, 0.25) * aside;
  s.camera.xyz.z() = draws.between(1.2, 1.6);
  s.camera.look_at = {grasp_W.x(), grasp_W.y(), 0.5 * grasp_W.z()};
  s.partner.arrives_s = kComes_s;
  const Does does = drawn(index);
  if (does == Does::Raises) {
    sim_hal::PartnerScriptEvent raise;
    raise.at_s = kComes_s + kRaises_s;
    raise.action = "sway";
    raise.by_m = draws.between(0.008, 0.02);
    raise.for_s = draws.between(0.8, 1.6);
    raise.direction = Vec3::UnitZ();
    s.partner.events.push_back(raise);
    return s;
  }
  // somebody else stands as near, his hands elsewhere or flat on the object
  s.partner.kind = "none";
  sim_hal::ScenarioPerson person;
  person.enters_s = kComes_s;
  const Eigen::Vector2d there = (grasp_W + draws.between(0.3, 0.45) * out).head<2>();
  const double side = draws.chance(0.5) ? 1.5 : -1.5;
  person.path = {there + side * aside.head<2>(), there};
  if (does == Does::Touches) {
    person.action = "reach";
    person.reach_to = "object";
  }
  s.people.push_back(person);
  return s;
}

/// Whether the robot took somebody for a partner when it last decided, and had seen his hand: "no", "seen",
/// "unseen".
const char* taken(const control::RunRecord& record) {
  if (std::none_of(record.states.begin(), record.states.end(),
                   [](const control::StateChange& s) { return s.state == Task::Decide; }))
    return "no";
  const bool estimated =
      record.decision && record.decision->partner_reason.find("is an estimate") != std::string::npos;
  return estimated ? "unseen" : "seen";
}

TrialRows run(const Trial& trial) {
  const std::uint64_t seed = trial.own_seed(27);
  sim_hal::Draws draws(seed, 8700);
  sim_hal::Scenario scenario = layout(trial.index, trial.seed, draws);
  scenario.task.height = kHeight_m;
  scenario.task.hold_s = kHold_s;
  const Does does = drawn(trial.index);
  const auto lift = run_whole_lift(scenario, trial.method, seed);
  if (!lift)
    return {{scenario.name, word(does), "", "", "", "", "", "", lift.error().text()},
            {},
            scenario.name + ": " + lift.error().text()};
  const std::string partner = taken(lift->record);
  double away_mm = NAN, sigma_mm = NAN, mahalanobis2 = NAN;
  const auto& decision = lift->record.decision;
  if (does == Does::Raises && decision && decision->partner) {
    const Vec3 error =
        decision->partner->position - sim_hal::object_pose(scenario.object) * scenario.partner.grasp;
    const Eigen::Matrix3d& covariance = decision->partner->covariance;
    away_mm = 1e3 * error.norm();
    sigma_mm = 1e3 * std::sqrt(covariance.trace() / 3.0);
    mahalanobis2 = error.dot(covariance.ldlt().solve(error));
  }
  const bool lifted = lift->record.outcome == control::RunRecord::Result::Lifted;
  TrialRows rows;
  rows.row = {scenario.name, word(does),           partner,
              cell(away_mm), cell(sigma_mm),       cell(mahalanobis2),
              cell(lifted),  cell(lift->tilt_deg), lift->record.reason};
  if (lifted != (does == Does::Raises)) rows.kept = KeptLift{scenario, seed};
  rows.words = fmt::format("{}, somebody {}: {}, {}: {}", scenario.name, word(does),
                           partner == "no" ? "no partner" : "taken for a partner",
                           lifted ? "lifted" : "not lifted", lift->record.reason);
  return rows;
}

std::vector<Figure> figures(const Results& r) {
  int raised = 0, unseen = 0, known = 0, lifted = 0, nobody = 0, taken = 0, moved = 0, within = 0, wrong = 0;
  std::vector<double> away_mm;
  for (const Row& row : r.trials.rows()) {
    const std::string& partner = r.trials.text(row, "partner");
    if (partner.empty()) continue;
    const bool was_lifted = r.trials.number(row, "lifted") > 0.5;
    if (r.trials.text(row, "does") != word(Does::Raises)) {
      ++nobody;
      taken += partner == "unseen";
      moved += was_lifted;
      continue;
    }
    ++raised;
    known += partner != "no";
    lifted += was_lifted;
    wrong += partner == "seen" && r.trials.number(row, "away_mm") > kWrong_mm;
    if (partner != "unseen") continue;
    ++unseen;
    away_mm.push_back(r.trials.number(row, "away_mm"));
    within += r.trials.number(row, "mahalanobis2") <= kNinetyFive;
  }
  return {{"known", "known to hold it", rate(known, raised), "%"},
          {"unseen", "of these, by its rise alone", rate(unseen, known), "%"},
          {"wrong", "the others: his hand seen 10 cm from where it is", rate(wrong, known - unseen), "%", 0.0,
           false},
          {"lifted", "lifted", rate(lifted, raised), "%"},
          {"away", "his hand from where it was said to be, median", quantile_estimate(away_mm, 0.5), "mm"},
          {"within", "within its 95 % ellipsoid", rate(within, unseen), "%"},
          {"taken", "nobody holds it: taken for a partner unseen", rate(taken, nobody), "%", 0.0, false},
          {"moved", "nobody holds it: reported as lifted", rate(moved, nobody), "%", 0.0, false}};
}

picture::Canvas plot(const Results& r) {
  BarPanel panel{"Of each (%)", {}, {}, {}};
  for (const Figure& f : figures(r))
    if (f.unit == "%" && f.estimate.n > 0) panel.bars.push_back(percent_bar(f.key, f.estimate));
  return draw_bar_plot({panel});
}

}  // namespace
}  // namespace hidden_hand_trials

Experiment hidden_hand_experiment() {
  using namespace hidden_hand_trials;
  Experiment e;
  e.name = "hidden-hand";
  e.title = "A camera behind the partner's back";
  e.thesis = "beyond it";
  e.question =
      "Random tables and boxes, seen from behind the partner, whose body hides his hand. In four trials of "
      "six he raises his end by 8 to 20 mm and puts it down again; in one somebody stands there and holds "
      "nothing, in one he touches it. Is it known that he holds it, how far from the truth, and is nobody "
      "taken for a partner?";
  e.default_trials = 60;
  e.columns = {"layout",       "does",   "partner",  "away_mm", "sigma_mm",
               "mahalanobis2", "lifted", "tilt_deg", "because"};
  e.run = run;
  e.task = task();
  e.figures = figures;
  e.plot = plot;
  return e;
}

}  // namespace colift::experiments
