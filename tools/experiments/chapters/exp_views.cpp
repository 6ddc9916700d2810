// What a second camera opposite the first one adds, before anything moves.

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <numbers>
#include <tuple>
#include <utility>

#include "hal/types/units.hpp"
#include "sim_hal/synthetic/hash_random.hpp"
#include "tools/experiments/bar_plot.hpp"
#include "tools/experiments/experiment.hpp"
#include "tools/experiments/trials/layouts.hpp"
#include "tools/experiments/trials/sighting.hpp"
#include "tools/visualization/palette.hpp"

namespace colift::experiments {
namespace views_trials {
namespace {

constexpr std::array kKinds{"table", "box", "pipe", "chair"};
constexpr double kLift_m = 0.05;

/// A camera anywhere around the object but behind the arm, and one about opposite.
sim_hal::Scenario scene_of(const Trial& trial) {
  sim_hal::Scenario s = mixed_layout(trial.index, trial.seed);
  sim_hal::Draws draws(trial.own_seed(51), 51);
  const hal::Vec3 middle = s.object.xyz + hal::Vec3(0.0, 0.0, 0.3);
  const double bearing = draws.between(-0.75, 0.75) * std::numbers::pi;
  const double opposite = bearing + std::numbers::pi + hal::deg_to_rad(draws.between(-40.0, 40.0));
  const auto place = [&](double angle) {
    sim_hal::ScenarioCamera c;
    const double away_m = draws.between(1.5, 2.0);
    c.xyz = {middle.x() + away_m * std::cos(angle), middle.y() + away_m * std::sin(angle),
             draws.between(1.2, 1.7)};
    c.look_at = middle + hal::Vec3(draws.between(-0.1, 0.1), draws.between(-0.1, 0.1), -0.1);
    return c;
  };
  s.camera = place(bearing);
  s.more_cameras = {place(opposite)};
  return s;
}

struct Seen {
  double unseen = NAN, cog_error_mm = NAN, cog_level_mm = NAN, partner_error_mm = NAN, agreement_mm = NAN;
  bool scene = false, partner = false;
  std::string words;
};

Seen see(const sim_hal::Scenario& scenario, const Trial& trial) {
  Seen out;
  // the scene first: a partner who is not seen does not hide what the map showed
  sim_hal::Scenario alone = scenario;
  alone.partner.kind = "none";
  auto scene = Observation::make(alone, trial.method, trial.own_seed(52), kLift_m);
  if (!scene) {
    out.words = scene.error().detail;
    return out;
  }
  out.scene = true;
  control::PerceptionSession& session = (*scene)->watch();
  const perception::Target& target = *session.analysis().scene.target;
  out.unseen = session.unseen();
  const hal::Vec3 off = target.cog - (*scene)->true_cog();
  out.cog_error_mm = 1e3 * off.norm();
  out.cog_level_mm = 1e3 * off.head<2>().norm();
  for (const control::ViewReport& view : session.views())
    if (std::isfinite(view.agreement_m)) out.agreement_mm = 1e3 * view.agreement_m;
  auto seen = Observation::make(scenario, trial.method, trial.own_seed(52), kLift_m);
  if (!seen) {
    out.words = seen.error().detail;
    for (std::size_t n = 1; n < session.views().size(); ++n)
      out.words += fmt::format("; camera {}: {}", n + 1, session.views()[n].reason);
    return out;
  }
  out.partner = true;
  out.partner_error_mm = 1e3 * ((*seen)->partner()->position - (*seen)->true_partner()).norm();
  return out;
}

TrialRows run(const Trial& trial) {
  sim_hal::Scenario scenario = scene_of(trial);
  const Seen two = see(scenario, trial);
  scenario.more_cameras.clear();
  const Seen one = see(scenario, trial);
  TrialRows rows;
  rows.row = {scenario.name,
              kKinds.at(static_cast<std::size_t>(trial.index) % kKinds.size()),
              cell(one.scene),
              cell(two.scene),
              cell(one.unseen),
              cell(two.unseen),
              cell(one.cog_error_mm),
              cell(two.cog_error_mm),
              cell(one.cog_level_mm),
              cell(two.cog_level_mm),
              cell(one.partner),
              cell(two.partner),
              cell(one.partner_error_mm),
              cell(two.partner_error_mm),
              cell(two.agreement_mm),
              one.words,
              two.words};
  rows.words =
      fmt::format("{}: unseen {:.0f} -> {:.0f} %, centre {:.0f} -> {:.0f} mm, partner {} -> {}",
                  scenario.name, 1e2 * one.unseen, 1e2 * two.unseen, one.cog_error_mm, two.cog_error_mm,
                  one.partner ? "seen" : "missed", two.partner ? "seen" : "missed");
  return rows;
}

/// Where both numbers of cameras gave one: one camera's, two cameras'.
std::pair<std::vector<double>, std::vector<double>> both(const Results& r, const std::string& column,
                                                         const std::string& kind = "") {
  std::pair<std::vector<double>, std::vector<double>> out;
  for (const Row& row : r.trials.rows()) {
    if (!kind.empty() && r.trials.text(row, "kind") != kind) continue;
    const double one = r.trials.number(row, column + "_1"), two = r.trials.number(row, column + "_2");
    if (!std::isfinite(one) || !std::isfinite(two)) continue;
    out.first.push_back(one);
    out.second.push_back(two);
  }
  return out;
}

Estimate median_of_ratios(const std::pair<std::vector<double>, std::vector<double>>& values) {
  std::vector<double> ratios;
  for (std::size_t i = 0; i < values.first.size(); ++i)
    if (values.first[i] > 0.0) ratios.push_back(values.second[i] / values.first[i]);
  return quantile_estimate(ratios, 0.5);
}

Estimate missed(const Results& r, const std::string& cameras) {
  int all = 0, none = 0;
  for (const Row& row : r.trials.rows()) {
    if (r.trials.number(row, "scene_1") < 0.5 || r.trials.number(row, "scene_2") < 0.5) continue;
    ++all;
    none += r.trials.number(row, "partner_" + cameras) < 0.5;
  }
  return rate(none, all);
}

std::vector<Figure> figures(const Results& r) {
  const auto cog = both(r, "cog_mm"), chair = both(r, "cog_mm", "chair"),
             level = both(r, "level_mm", "chair"), partner = both(r, "partner_mm");
  return {{"unseen_ratio", "unseen space around the object, two cameras against one (median of ratios)",
           median_of_ratios(both(r, "unseen")), "%", 0.5, false},
          {"missed_1", "partner not found with one camera", missed(r, "1"), "%"},
          {"missed_2", "partner not found with two", missed(r, "2"), "%", 1.0 / 500.0, false},
          {"chair_1", "centre of gravity of a chair, one camera (median error)",
           quantile_estimate(chair.first, 0.5), "mm"},
          {"chair_2", "the same with two", quantile_estimate(chair.second, 0.5), "mm"},
          {"level_1", "the same across the plumb line, one camera (median)",
           quantile_estimate(level.first, 0.5), "mm"},
          {"level_2", "the same with two", quantile_estimate(level.second, 0.5), "mm"},
          {"cog_1", "centre of gravity of all, one camera (90 % of errors)",
           quantile_estimate(cog.first, 0.9), "mm"},
          {"cog_2", "the same with two", quantile_estimate(cog.second, 0.9), "mm"},
          {"partner_1", "partner's grasp where both see it, one camera (90 % of errors)",
           quantile_estimate(partner.first, 0.9), "mm"},
          {"partner_2", "the same with two", quantile_estimate(partner.second, 0.9), "mm"},
          {"agreement", "what both cameras show at rest, apart (median of medians)",
           quantile_estimate(r.trials.numbers("agreement_mm"), 0.5), "mm"}};
}

picture::Canvas plot(const Results& r) {
  std::vector<BarPanel> panels;
  for (const auto& [column, title, scale] :
       {std::tuple{"unseen", "unseen space around the object (%), one and two cameras; median, 10 and 90 %",
                   100.0},
        std::tuple{"cog_mm", "error of the centre of gravity (mm)", 1.0},
        std::tuple{"partner_mm", "error of the partner's grasp (mm)", 1.0}}) {
    BarPanel panel;
    panel.title = title;
    for (const char* kind : kKinds) {
      const auto values = both(r, column, kind);
      int cameras = 1;
      for (const auto* v : {&values.first, &values.second}) {
        if (!v->empty())
          panel.bars.push_back({fmt::format("{} {}", kind, cameras), scale * quantile(*v, 0.5), cameras == 2,
                                scale * quantile(*v, 0.1), scale * quantile(*v, 0.9)});
        ++cameras;
      }
    }
    if (!panel.bars.empty()) panels.push_back(std::move(panel));
  }
  return draw_bar_plot(panels);
}

}  // namespace
}  // namespace views_trials

Experiment views_experiment() {
  using namespace views_trials;
  Experiment e;
  e.name = "views";
  e.title = "A second camera";
  e.thesis = "beyond";
  e.question =
      "Tables, boxes, pipes and chairs of random size and pose, seen by one camera anywhere around the "
      "object, and by this one and a second one about opposite, each at its own time: how much of the space "
      "around the object nobody sees, how far off the centre of gravity is, and whether and where the "
      "partner's hand is found.";
  e.default_trials = 100;
  e.columns = {"layout",       "kind",         "scene_1",      "scene_2",    "unseen_1",  "unseen_2",
               "cog_mm_1",     "cog_mm_2",     "level_mm_1",   "level_mm_2", "partner_1", "partner_2",
               "partner_mm_1", "partner_mm_2", "agreement_mm", "because_1",  "because_2"};
  e.run = run;
  e.trials_set = "nothing";
  e.figures = figures;
  e.plot = plot;
  return e;
}

}  // namespace colift::experiments
