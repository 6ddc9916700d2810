// Thesis 6.2: how soon does the decision follow the partner's hand?

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "control/arm/arm_commander.hpp"
#include "sim_hal/mujoco/devices/sim_devices.hpp"
#include "sim_hal/synthetic/hash_random.hpp"
#include "tools/experiments/experiment.hpp"
#include "tools/experiments/trials/layouts.hpp"
#include "tools/experiments/trials/sighting.hpp"
#include "tools/visualization/line_plot.hpp"
#include "tools/visualization/palette.hpp"

namespace colift::experiments {
namespace realtime_trials {
namespace {

constexpr double kHeight_m = 0.05;
constexpr int kPlaces = 3;            // after the first one
constexpr double kBetween_s = 2.5;    // from hold to hold
constexpr double kInTransit_s = 1.0;  // a moved hand holds one second after it let go
constexpr double kFollows_m = 0.05;   // of the place that he has moved to
constexpr double kGoal_ms = 150.0, kCompute_ms = 15.0;

/// One touch of the partner, from his hand at rest to the decision.
struct Answer {
  bool arm_in_view = false;
  double at_rest_s = 0.0, delay_ms = NAN, see_ms = NAN, decide_ms = NAN, error_m = NAN, moved_m = NAN;
  int chosen = -1;
};

/// Watches and decides while the arm stands or moves.
class Session {
 public:
  Session(Observation& observation, control::Method method)
      : observation_(observation),
        method_(method),
        arm_(sim_hal::make_sim_arm(observation.world())),
        geometry_(planner::arm_geometry(observation.world().model()).value()),
        config_(config_for(method)),
        commander_(*arm_, observation.world().model(), geometry_, config_.task, config_.load,
                   control::Drive::InStep, config_.setpoints) {}

  hal::Result<> start() {
    if (auto ok = arm_->configure(); !ok) return ok;
    return commander_.start();
  }

  // until the partner has been seen at his place that begins at `at_rest_s`, or half a second too late
  Answer follow(double at_rest_s, const hal::Vec3& place_W, const planner::Trajectory* way) {
    Answer answer;
    answer.at_rest_s = at_rest_s;
    answer.arm_in_view = way != nullptr;
    bool in_transit = false;
    while (hal::seconds(observation_.world().elapsed()) < at_rest_s + 1.0) {
      commander_.begin_cycle();
      if (way != nullptr && !in_transit) in_transit = commander_.follow(*way).has_value();
      auto frame = observation_.camera().next_frame(std::chrono::milliseconds(0));
      commander_.end_cycle();
      if (!frame) continue;
      const control::RobotPosture posture{observation_.world().arm_state().q_rad,
                                          hal::posture_of(observation_.world().hand_state())};
      const hal::Timestamp begin = clock_.now();
      auto sight = observation_.watch().observe_partner(*frame, posture);
      const hal::Timestamp seen = clock_.now();
      if (!sight || !sight->event || sight->event->kind != perception::PartnerEvent::Kind::Grasped) continue;
      if (hal::seconds(observation_.world().elapsed()) < at_rest_s - 0.2) continue;
      const auto grasp = observation_.watch().tracker().grasp();
      const auto outcome = observation_.decide_for(*grasp, config_);
      const hal::Timestamp decided = clock_.now();
      answer.see_ms = 1e3 * hal::seconds(seen - begin);
      answer.decide_ms = 1e3 * hal::seconds(decided - seen);
      answer.delay_ms = 1e3 * (hal::seconds(observation_.world().elapsed()) - at_rest_s);
      answer.error_m = (grasp->position - place_W).norm();
      if (outcome && outcome->decision.chosen) {
        const auto& c = outcome->candidates[*outcome->decision.chosen];
        answer.chosen = c.id;
        answer.moved_m = last_.allFinite() ? (c.position - last_).norm() : NAN;
        last_ = c.position;
      }
      return answer;
    }
    return answer;
  }
  void begin_with(const hal::Vec3& chosen) { last_ = chosen; }

 private:
  Observation& observation_;
  control::Method method_;
  std::unique_ptr<hal::Arm> arm_;
  planner::ArmGeometry geometry_;
  control::Config config_;
  control::ArmCommander commander_;
  hal::SteadyClock clock_;
  hal::Vec3 last_ = hal::Vec3::Constant(NAN);
};

TrialRows run(const Trial& trial) {
  const std::uint64_t seed = trial.own_seed(7);
  sim_hal::Scenario scenario = seen_from(trial.view, table_layout(trial.index, trial.seed));
  sim_hal::Draws draws(seed, 7700);
  // along the far edge, each place a hand's width and more from the one before
  const double half = 0.5 * scenario.object.size[1] - 0.08;
  std::vector<hal::Vec3> places{scenario.partner.grasp};
  for (int i = 0; i < kPlaces; ++i) {
    hal::Vec3 p = places.back();
    for (int attempt = 0; attempt < 50 && std::abs(p.y() - places.back().y()) < 0.1; ++attempt)
      p.y() = draws.between(-half, half);
    places.push_back(p);
    sim_hal::PartnerScriptEvent move;
    move.at_s = scenario.partner.arrives_s + kBetween_s * (i + 1) - kInTransit_s;
    move.action = "move";
    move.to = p;
    scenario.partner.events.push_back(move);
  }
  const auto refused = [&](const std::string& why) {
    Row row{scenario.name};
    row.resize(8);
    row.push_back(why);
    return TrialRows{row, {}, scenario.name + ": " + why};
  };
  const double first_rest_s = scenario.partner.arrives_s;
  auto observation = Observation::make(scenario, trial.method, seed, kHeight_m);
  if (!observation) return refused(observation.error().text());
  const double first_delay_ms = 1e3 * (hal::seconds((*observation)->world().elapsed()) - first_rest_s);
  const auto outcome = (*observation)->decide(config_for(trial.method));
  if (!outcome) return refused(outcome.error().text());
  if (!outcome->decision.chosen) return refused(outcome->decision.reason);
  const auto plan = (*observation)->plan(outcome->candidates[*outcome->decision.chosen]);

  Session session(**observation, trial.method);
  if (auto ok = session.start(); !ok) return refused(ok.error().text());
  session.begin_with(outcome->candidates[*outcome->decision.chosen].position);
  const hal::Pose X_WT = sim_hal::object_pose(scenario.object);
  TrialRows rows;
  std::vector<double> delays{first_delay_ms}, compute;
  int followed = 0, asked = 0;
  for (int i = 1; i <= kPlaces; ++i) {
    const hal::Vec3 place = X_WT * places[static_cast<std::size_t>(i)];
    // at the last place the arm is on its way to the pre-grasp, in the picture
    const bool moving = plan && i == kPlaces;
    const Answer a = session.follow(first_rest_s + kBetween_s * i, place, moving ? &plan->transit : nullptr);
    ++asked;
    const bool follows = a.chosen >= 0 && a.error_m < kFollows_m;
    followed += follows;
    delays.push_back(a.delay_ms);
    if (!std::isnan(a.see_ms)) compute.push_back(a.see_ms + a.decide_ms);
    rows.details.push_back({cell(i), cell(a.arm_in_view), cell(a.delay_ms), cell(a.see_ms), cell(a.decide_ms),
                            cell(1e3 * a.error_m), cell(1e3 * a.moved_m), cell(follows)});
  }
  rows.row = {scenario.name,
              cell(first_delay_ms),
              cell(asked),
              cell(followed),
              cell(quantile(delays, 0.5)),
              cell(quantile(delays, 1.0)),
              cell(quantile(compute, 0.5)),
              cell(quantile(compute, 1.0)),
              ""};
  rows.words =
      fmt::format("{}: followed {} of {}, {:.0f} ms after the hand came to rest, {:.1f} ms of computing",
                  scenario.name, followed, asked, quantile(delays, 0.5), quantile(compute, 0.5));
  return rows;
}

std::vector<Figure> figures(const Results& r) {
  std::vector<double> delay, delay_arm, compute, compute_arm, error;
  int followed = 0, followed_arm = 0, n = 0, n_arm = 0;
  for (const Row& d : r.details.rows()) {
    const bool arm = r.details.number(d, "arm_in_view") > 0.5, ok = r.details.number(d, "follows") > 0.5;
    const double ms = r.details.number(d, "see_ms") + r.details.number(d, "decide_ms");
    (arm ? n_arm : n)++;
    (arm ? followed_arm : followed) += ok;
    (arm ? delay_arm : delay).push_back(r.details.number(d, "delay_ms"));
    (arm ? compute_arm : compute).push_back(ms);
    error.push_back(r.details.number(d, "error_mm"));
  }
  std::vector<double> first = r.trials.numbers("first_delay_ms");
  delay.insert(delay.end(), first.begin(), first.end());
  const char* thesis = "less than 2 s";
  return {
      {"compute_p99_ms", "computing of one decision, 99 % below", quantile_estimate(compute, 0.99), "ms",
       kCompute_ms, false, thesis},
      {"compute_median_ms", "computing of one decision, median", quantile_estimate(compute, 0.5), "ms"},
      {"compute_arm_p99_ms", "the same with the arm in view, 99 % below",
       quantile_estimate(compute_arm, 0.99), "ms", kCompute_ms, false},
      {"delay_median_ms",
       "hand at rest to decision, median",
       quantile_estimate(delay, 0.5),
       "ms",
       {},
       true,
       thesis},
      {"delay_p95_ms", "hand at rest to decision, 95 % below", quantile_estimate(delay, 0.95), "ms", kGoal_ms,
       false, thesis},
      {"delay_arm_p95_ms", "the same with the arm in view, 95 % below", quantile_estimate(delay_arm, 0.95),
       "ms", kGoal_ms, false},
      {"followed", "moves of the hand that the decision followed", rate(followed, n), "%", {}, true, "yes"},
      {"followed_arm", "the same with the arm in view", rate(followed_arm, n_arm), "%"},
      {"partner_error_p90_mm", "error of the partner's grasp, 90 % below", quantile_estimate(error, 0.9),
       "mm"}};
}

picture::Canvas plot(const Results& r) {
  const auto curve = [&](const char* name, const picture::Colour& colour, bool arm, bool compute) {
    std::vector<double> v;
    for (const Row& d : r.details.rows())
      if ((r.details.number(d, "arm_in_view") > 0.5) == arm)
        v.push_back(compute ? r.details.number(d, "see_ms") + r.details.number(d, "decide_ms")
                            : r.details.number(d, "delay_ms"));
    std::erase_if(v, [](double x) { return std::isnan(x); });
    std::sort(v.begin(), v.end());
    picture::PlotLine line{name, colour, {}, {}};
    for (std::size_t i = 0; i < v.size(); ++i) {
      line.x.push_back(v[i]);
      line.y.push_back(100.0 * static_cast<double>(i + 1) / static_cast<double>(v.size()));
    }
    return line;
  };
  picture::LinePlot plot;
  plot.x_title = "hand at rest to decision (ms)";
  picture::PlotPanel panel;
  panel.title = "Answers given by then (%)";
  panel.lines = {curve("arm at rest", picture::kPartner, false, false),
                 curve("arm in view", picture::kRobot, true, false)};
  panel.y_low = 0.0;
  panel.y_high = 100.0;
  plot.panels.push_back(std::move(panel));
  return picture::draw_line_plot(plot);
}

}  // namespace
}  // namespace realtime_trials

Experiment realtime_experiment() {
  using namespace realtime_trials;
  Experiment e;
  e.name = "realtime";
  e.title = "Real-time grasp decision";
  e.thesis = "6.2, figure 6.3";
  e.question =
      "The partner takes a table and moves along its edge three times; the last time the arm is on its way. "
      "Time from his hand at rest to the decision, and whether it follows him. Computing is measured, all "
      "else is "
      "simulated time.";
  e.default_trials = 60;
  e.times_computing = true;
  e.columns = {"layout",
               "first_delay_ms",
               "moves",
               "followed",
               "delay_median_ms",
               "delay_worst_ms",
               "compute_median_ms",
               "compute_worst_ms",
               "because"};
  e.detail_columns = {"place",     "arm_in_view", "delay_ms",        "see_ms",
                      "decide_ms", "error_mm",    "choice_moved_mm", "follows"};
  e.run = run;
  e.figures = figures;
  e.plot = plot;
  return e;
}

}  // namespace colift::experiments
