#include "tools/log/comparison.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace colift::tools {
namespace {

constexpr double kSamePlace_m = 1e-3, kBeside_m = 0.05;
constexpr const char* kLift = "lift";
constexpr const char* kHold = "hold";

std::vector<ConfigDifference> config_differences(const RecordedRun& a, const RecordedRun& b) {
  std::vector<ConfigDifference> out;
  const auto value = [](const RecordedRun& run, const std::string& key) {
    const auto found = run.config.find(key);
    return found == run.config.end() ? std::nullopt : std::optional(found->second);
  };
  std::map<std::string, std::string> keys = a.config;
  keys.insert(b.config.begin(), b.config.end());
  for (const auto& [key, unused] : keys)
    if (const auto in_a = value(a, key), in_b = value(b, key); in_a != in_b)
      out.push_back({key, {in_a, in_b}});
  return out;
}

std::vector<StateComparison> compare_states(const Both<const RecordedRun*>& runs) {
  std::vector<StateComparison> out;
  for (std::size_t i = 0; i < 2; ++i)
    for (const RecordedState& s : runs[i]->states) {
      auto row =
          std::find_if(out.begin(), out.end(), [&](const StateComparison& c) { return c.state == s.state; });
      if (row == out.end()) {
        out.push_back({s.state, {}, {}});
        row = out.end() - 1;
      }
      if (!row->entered_s[i]) row->entered_s[i] = s.from_s;
      row->total_s[i] += s.to_s - s.from_s;
    }
  return out;
}

/// The same candidate of another decision, if it has it.
const RecordedCandidate* same_in(const RecordedDecision& other, const RecordedCandidate& c) {
  const RecordedCandidate* found = other.candidate(c.id);
  const bool same = found != nullptr && found->kind == c.kind && c.position_W && found->position_W &&
                    (*c.position_W - *found->position_W).norm() < kSamePlace_m;
  return same ? found : nullptr;
}

/// Those around the chosen one were added after the choice: where that is another, so are they.
bool is_beside_choice(const RecordedDecision& d, const RecordedCandidate& c) {
  const RecordedCandidate* chosen = d.chosen ? d.candidate(*d.chosen) : nullptr;
  return chosen != nullptr && chosen->position_W && c.position_W &&
         (*chosen->position_W - *c.position_W).norm() < kBeside_m;
}

bool has_all_of(const RecordedDecision& other, const RecordedDecision& d) {
  return std::all_of(d.candidates.begin(), d.candidates.end(), [&](const RecordedCandidate& c) {
    return same_in(other, c) != nullptr || is_beside_choice(d, c);
  });
}

/// "chosen" is no other verdict than "ok": which one is chosen is said apart.
std::string possible_or(const std::string& verdict) {
  return verdict == "chosen" ? "ok" : verdict;
}

DecisionComparison compare_decisions(const RecordedDecision& a, const RecordedDecision& b) {
  DecisionComparison out;
  const auto chosen = [](const RecordedDecision& d) { return d.chosen ? d.candidate(*d.chosen) : nullptr; };
  out.chosen = {chosen(a), chosen(b)};
  if (out.chosen[0] != nullptr && out.chosen[1] != nullptr && out.chosen[0]->position_W &&
      out.chosen[1]->position_W)
    out.grasps_apart_m = (*out.chosen[0]->position_W - *out.chosen[1]->position_W).norm();
  if (a.partner_W && b.partner_W) out.partners_apart_m = (*a.partner_W - *b.partner_W).norm();
  out.same_candidates = has_all_of(a, b) && has_all_of(b, a);
  if (!out.same_candidates) return out;
  for (const RecordedCandidate& c : a.candidates) {
    const RecordedCandidate* other = same_in(b, c);
    if (other != nullptr && possible_or(c.verdict) != possible_or(other->verdict))
      out.verdicts.push_back({c.id, {c.verdict, other->verdict}, {c.reason, other->reason}});
  }
  return out;
}

const RecordedCurve* curve_of(const RecordedRun& run, Quantity quantity) {
  const auto found = run.curves.find(quantity);
  return found == run.curves.end() || found->second.t_s.empty() ? nullptr : &found->second;
}

/// Values of a curve while the run was in a state.
std::vector<double> during(const RecordedRun& run, Quantity quantity, std::string_view state) {
  std::vector<double> out;
  const RecordedCurve* curve = curve_of(run, quantity);
  if (curve == nullptr) return out;
  for (const RecordedState& s : run.states)
    if (s.state == state)
      for (std::size_t i = 0; i < curve->t_s.size(); ++i)
        if (curve->t_s[i] >= s.from_s && curve->t_s[i] <= s.to_s) out.push_back(curve->value[i]);
  return out;
}

std::optional<double> median_of(std::vector<double> values) {
  if (values.empty()) return std::nullopt;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

std::optional<double> extreme(const RecordedRun& run, Quantity quantity, double sign) {
  const RecordedCurve* curve = curve_of(run, quantity);
  if (curve == nullptr) return std::nullopt;
  double most = sign * curve->value.front();
  for (const double v : curve->value) most = std::max(most, sign * v);
  return sign * most;
}

/// Time at speed scale 0.
std::optional<double> waited_s(const RecordedRun& run) {
  const RecordedCurve* curve = curve_of(run, Quantity::SpeedScale);
  if (curve == nullptr) return std::nullopt;
  double out = 0.0;
  for (std::size_t i = 0; i + 1 < curve->t_s.size(); ++i)
    if (curve->value[i] <= 0.0) out += curve->t_s[i + 1] - curve->t_s[i];
  return out;
}

std::vector<FigureComparison> compare_figures(const Both<const RecordedRun*>& runs) {
  std::vector<FigureComparison> out;
  const auto add = [&](const char* name, const char* title, const char* unit, auto value) {
    FigureComparison row{name, title, unit, {value(*runs[0]), value(*runs[1])}};
    if (row.value[0] || row.value[1]) out.push_back(std::move(row));
  };
  using Value = std::optional<double>;
  add("duration_s", "duration", "s", [](const RecordedRun& r) { return Value(r.end_s); });
  add("decided_share", "share by the decision", "",
      [](const RecordedRun& r) { return r.decision ? r.decision->share : Value(); });
  add("cost", "cost of the chosen grasp", "",
      [](const RecordedRun& r) { return r.decision ? r.decision->cost : Value(); });
  add("held_share", "share while held, median", "",
      [](const RecordedRun& r) { return median_of(during(r, Quantity::Share, kHold)); });
  add("held_load_n", "load while held, median", "N",
      [](const RecordedRun& r) { return median_of(during(r, Quantity::Load, kHold)); });
  add("max_load_n", "max load", "N", [](const RecordedRun& r) { return extreme(r, Quantity::Load, 1.0); });
  add("max_height_m", "max height", "m",
      [](const RecordedRun& r) { return extreme(r, Quantity::Height, 1.0); });
  add("max_tilt_deg", "max tilt", "deg",
      [](const RecordedRun& r) { return extreme(r, Quantity::Tilt, 1.0); });
  add("max_slip_m", "max slip in the hand", "m",
      [](const RecordedRun& r) { return extreme(r, Quantity::Slip, 1.0); });
  add("min_distance_m", "nearest person to the arm", "m",
      [](const RecordedRun& r) { return extreme(r, Quantity::Distance, -1.0); });
  add("waited_s", "waited for somebody near", "s", waited_s);
  return out;
}

/// The value of a curve at a time, between its neighbours; nothing outside of it, or in a gap.
std::optional<double> value_at(const RecordedCurve& curve, double t_s) {
  constexpr double kMaxGap_s = 0.25;
  const auto after = std::lower_bound(curve.t_s.begin(), curve.t_s.end(), t_s);
  if (after == curve.t_s.end()) return std::nullopt;
  const auto j = static_cast<std::size_t>(after - curve.t_s.begin());
  if (*after == t_s) return curve.value[j];
  if (j == 0 || curve.t_s[j] - curve.t_s[j - 1] > kMaxGap_s) return std::nullopt;
  const double part = (t_s - curve.t_s[j - 1]) / (curve.t_s[j] - curve.t_s[j - 1]);
  return curve.value[j - 1] + part * (curve.value[j] - curve.value[j - 1]);
}

std::optional<CurveComparison> compare_curves(const Comparison& c, Quantity quantity) {
  const RecordedCurve* a = curve_of(*c.run[0], quantity);
  const RecordedCurve* b = curve_of(*c.run[1], quantity);
  if (a == nullptr || b == nullptr) return std::nullopt;
  CurveComparison out{quantity};
  double squares = 0.0;
  std::size_t count = 0;
  const double shift_s = c.zero_s[1] - c.zero_s[0];  // exactly 0 of two equal runs
  for (std::size_t i = 0; i < a->t_s.size(); ++i) {
    const auto other = value_at(*b, a->t_s[i] + shift_s);
    if (!other) continue;
    const double difference = *other - a->value[i];
    squares += difference * difference;
    ++count;
    if (std::abs(difference) <= std::abs(out.max_difference)) continue;
    out.max_difference = difference;
    out.at_s = a->t_s[i] - c.zero_s[0];
  }
  if (count == 0) return std::nullopt;
  out.rms_difference = std::sqrt(squares / static_cast<double>(count));
  return out;
}

}  // namespace

Comparison compare(const RecordedRun& a, const RecordedRun& b) {
  Comparison out;
  out.run = {&a, &b};
  const auto lift_a = a.entered_s(kLift), lift_b = b.entered_s(kLift);
  out.aligned = lift_a && lift_b ? kLift : "start";
  if (lift_a && lift_b)
    out.zero_s = {*lift_a, *lift_b};
  else
    for (std::size_t i = 0; i < 2; ++i)
      if (!out.run[i]->states.empty()) out.zero_s[i] = out.run[i]->states.front().from_s;
  out.config = config_differences(a, b);
  out.states = compare_states(out.run);
  if (a.decision && b.decision) out.decision = compare_decisions(*a.decision, *b.decision);
  out.figures = compare_figures(out.run);
  for (const QuantityStyle& style : kQuantities)
    if (const auto done = compare_curves(out, style.quantity)) out.curves.push_back(*done);
  return out;
}

std::string setting_text(const std::optional<std::string>& value) {
  if (!value) return "not there";
  return value->empty() ? "not set" : *value;
}

int digits_of(const FigureComparison& figure) {
  return figure.unit == "m" ? 4 : 3;
}

std::string value_text(const std::optional<double>& value, int digits) {
  return value ? fmt::format("{:.{}f}", *value, digits) : "-";
}

std::string difference_text(const Both<std::optional<double>>& value, int digits) {
  return value[0] && value[1] ? fmt::format("{:+.{}f}", *value[1] - *value[0], digits) : "";
}

bool Comparison::same() const {
  const auto& [a, b] = run;
  const auto state_same = [](const StateComparison& s) {
    return s.entered_s[0] == s.entered_s[1] && s.total_s[0] == s.total_s[1];
  };
  const auto figure_same = [](const FigureComparison& f) { return f.value[0] == f.value[1]; };
  const auto curve_same = [](const CurveComparison& c) { return c.max_difference == 0.0; };
  return a->outcome == b->outcome && a->reason == b->reason && config.empty() &&
         std::all_of(states.begin(), states.end(), state_same) &&
         a->decision.has_value() == b->decision.has_value() &&
         (!decision || (decision->same_candidates && decision->verdicts.empty() &&
                        a->decision->chosen == b->decision->chosen)) &&
         std::all_of(figures.begin(), figures.end(), figure_same) &&
         std::all_of(curves.begin(), curves.end(), curve_same);
}

}  // namespace colift::tools
