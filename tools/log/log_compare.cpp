// Two runs side by side, as text or as a document.

#include <fmt/format.h>

#include <cstdio>
#include <nlohmann/json.hpp>

#include "tools/cli/session.hpp"
#include "tools/log/cmd_log.hpp"
#include "tools/log/comparison.hpp"
#include "tools/run/run_text.hpp"
#include "tools/telemetry/channels/json_parts.hpp"

namespace colift::tools {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kColumns = 80;
constexpr std::size_t kShownVerdicts = 12;

template <class T>
Json json_of(const std::optional<T>& value) {
  return value ? Json(*value) : Json(nullptr);
}

template <class T>
Json json_of(const Both<T>& both) {
  return {{"a", json_of(both[0])}, {"b", json_of(both[1])}};
}

Json json_of(const RecordedRun& run) {
  return {{"file", run.file.string()},
          {"version", run.version},
          {"command", run.command},
          {"started", run.started},
          {"method", run.method},
          {"seed", run.seed},
          {"outcome", run.outcome.empty() ? Json(nullptr) : Json(run.outcome)},
          {"because", run.reason},
          {"damage", run.damage}};
}

Json json_of(const RecordedCandidate* c) {
  if (c == nullptr) return nullptr;
  return {{"id", c->id},
          {"kind", c->kind},
          {"position",
           c->position_W ? Json{c->position_W->x(), c->position_W->y(), c->position_W->z()} : Json(nullptr)},
          {"share", json_of(c->share)},
          {"cost", json_of(c->cost)}};
}

Json json_of(const DecisionComparison& d) {
  Json verdicts = Json::array();
  for (const VerdictDifference& v : d.verdicts)
    verdicts.push_back({{"id", v.id},
                        {"a", {{"verdict", v.verdict[0]}, {"because", v.reason[0]}}},
                        {"b", {{"verdict", v.verdict[1]}, {"because", v.reason[1]}}}});
  return {{"chosen", {{"a", json_of(d.chosen[0])}, {"b", json_of(d.chosen[1])}}},
          {"grasps_apart_m", json_of(d.grasps_apart_m)},
          {"partners_apart_m", json_of(d.partners_apart_m)},
          {"same_candidates", d.same_candidates},
          {"verdicts", std::move(verdicts)}};
}

Json document(const Comparison& c) {
  Json config = Json::array(), states = Json::array(), figures = Json::array(), curves = Json::array();
  for (const ConfigDifference& d : c.config)
    config.push_back({{"key", d.key}, {"a", json_of(d.value[0])}, {"b", json_of(d.value[1])}});
  for (const StateComparison& s : c.states)
    states.push_back({{"state", s.state},
                      {"entered_s", json_of(s.entered_s)},
                      {"total_s", {{"a", s.total_s[0]}, {"b", s.total_s[1]}}}});
  for (const FigureComparison& f : c.figures)
    figures.push_back(
        {{"name", f.name}, {"unit", f.unit}, {"a", json_of(f.value[0])}, {"b", json_of(f.value[1])}});
  for (const CurveComparison& curve : c.curves)
    curves.push_back({{"quantity", style_of(curve.quantity).name},
                      {"unit", style_of(curve.quantity).unit},
                      {"max_difference", curve.max_difference},
                      {"at_s", curve.at_s},
                      {"rms_difference", curve.rms_difference}});
  return {{"schema", "colift.log.compare/1"},
          {"same", c.same()},
          {"a", json_of(*c.run[0])},
          {"b", json_of(*c.run[1])},
          {"config", std::move(config)},
          {"states", std::move(states)},
          {"decision", c.decision ? json_of(*c.decision) : Json(nullptr)},
          {"figures", std::move(figures)},
          {"curves", {{"aligned", c.aligned}, {"differences", std::move(curves)}}}};
}

/// One line of a recording, which may be a stranger's.
std::string shown(const std::string& text) {
  return one_line(text, false);
}

std::string heading(const char* name, const RecordedRun& run) {
  const std::string what = run.outcome.empty() ? "the recording ends before the run"
                                               : fmt::format("{}: {}", run.outcome, run.reason);
  std::string out = entry(name,
                          shown(fmt::format("{}, version {}, method {}, seed {}", run.file.string(),
                                            run.version, run.method, run.seed)),
                          4, kColumns) +
                    entry("", shown(what), 4, kColumns);
  for (const std::string& damage : run.damage) out += entry("", shown(damage), 4, kColumns);
  return out;
}

std::string row(const std::string& name, const Both<std::string>& value, const std::string& difference) {
  std::string out = fmt::format("  {:<34}{:>12}{:>12}{:>14}", name, value[0], value[1], difference);
  out.resize(out.find_last_not_of(' ') + 1);
  return out + '\n';
}

std::string settings_text(const Comparison& c) {
  if (c.config.empty()) return "same configuration, scenario and robot\n";
  std::string out = fmt::format("{} settings differ\n", c.config.size());
  for (const ConfigDifference& d : c.config)
    out += entry(
        "", shown(fmt::format("{}: {} -> {}", d.key, setting_text(d.value[0]), setting_text(d.value[1]))), 2,
        kColumns);
  return out;
}

std::string grasp_text(const RecordedCandidate* c) {
  if (c == nullptr) return "none chosen";
  return fmt::format("candidate {}{}", c->id, c->position_W ? " at " + place_text(*c->position_W) : "");
}

std::string decision_text(const Comparison& c) {
  if (!c.decision) return "decision: not in both recordings\n";
  const DecisionComparison& d = *c.decision;
  std::string out = "decision\n";
  out +=
      entry("  A", grasp_text(d.chosen[0]), 6, kColumns) + entry("  B", grasp_text(d.chosen[1]), 6, kColumns);
  if (d.grasps_apart_m) out += fmt::format("  the grasps are {} apart\n", metres_text(*d.grasps_apart_m));
  if (d.partners_apart_m)
    out += fmt::format("  the partner's grasps, as seen, are {} apart\n", metres_text(*d.partners_apart_m));
  if (!d.same_candidates) return out + "  the candidates are not the same ones\n";
  out += fmt::format("  {} of {} candidates have another verdict\n", d.verdicts.size(),
                     c.run[0]->decision->candidates.size());
  for (std::size_t i = 0; i < std::min(d.verdicts.size(), kShownVerdicts); ++i) {
    const VerdictDifference& v = d.verdicts[i];
    out += entry(fmt::format("  {:>5}", v.id),
                 shown(fmt::format("{} -> {}: {}", v.verdict[0], v.verdict[1],
                                   v.reason[1].empty() ? v.reason[0] : v.reason[1])),
                 8, kColumns);
  }
  if (d.verdicts.size() > kShownVerdicts)
    out += fmt::format("  and {} more: --json has all\n", d.verdicts.size() - kShownVerdicts);
  return out;
}

std::string text(const Comparison& c) {
  std::string out = heading("A", *c.run[0]) + heading("B", *c.run[1]);
  out += settings_text(c) + decision_text(c);
  out += row("state: entered at (s)", {"A", "B"}, "B - A");
  for (const StateComparison& s : c.states)
    out += row("  " + shown(s.state), {value_text(s.entered_s[0], 2), value_text(s.entered_s[1], 2)},
               difference_text(s.entered_s, 2));
  out += row("figure", {"A", "B"}, "B - A");
  for (const FigureComparison& f : c.figures)
    out += row("  " + f.title + (f.unit.empty() ? "" : " (" + f.unit + ")"),
               {value_text(f.value[0], digits_of(f)), value_text(f.value[1], digits_of(f))},
               difference_text(f.value, digits_of(f)));
  out += fmt::format("  curves, time 0 at the {}\n", c.aligned == "lift" ? "begin of the lift" : "start");
  for (const CurveComparison& curve : c.curves)
    out += fmt::format("    {:<38}rms {:.3g}, at most {:+.3g} at {:.2f} s\n", style_of(curve.quantity).title,
                       curve.rms_difference, curve.max_difference, curve.at_s);
  if (c.same()) out += "the same in everything that is compared\n";
  return out;
}

}  // namespace

int log_compare(const CommonOptions& common, const LogOptions& options) {
  constexpr const char* kCommand = "log compare";
  const auto a = read_recorded_run(options.file);
  if (!a) return report_error(kCommand, a.error());
  const auto b = read_recorded_run(options.other);
  if (!b) return report_error(kCommand, b.error());
  const Comparison c = compare(*a, *b);
  if (options.out)
    if (auto done = write_comparison_page(*options.out, c, common.command); !done)
      return report_error(kCommand, done.error());
  std::fputs((common.json ? telemetry::dumped(document(c)) + "\n" : text(c)).c_str(), stdout);
  if (options.out && !common.json && !common.quiet)
    std::fputs(fmt::format("page: {}\n", options.out->string()).c_str(), stdout);
  return kDone;
}

}  // namespace colift::tools
