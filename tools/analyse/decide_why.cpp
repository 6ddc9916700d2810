#include "tools/analyse/decide_why.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "planner/grasp/grasp_candidates.hpp"
#include "tools/analyse/words.hpp"

namespace colift::tools {
namespace {

using planner::Verdict;

bool possible(const planner::GraspCandidate& c) {
  return c.verdict == Verdict::Ok || c.verdict == Verdict::Chosen;
}

void cost_weight(const planner::ScoredCandidate& s, const planner::SharingWeights& w, WhyCandidate& out) {
  const double e2 = w.epsilon * w.epsilon;
  const auto square = [](double x) { return x * x; };
  out.partner_force = s.wrenches.partner.force.squaredNorm();
  out.partner_torque = square(w.omega1_per_m) * s.wrenches.partner.torque.squaredNorm();
  out.robot_force = e2 * s.wrenches.robot.force.squaredNorm();
  out.robot_torque = e2 * square(w.omega2_per_m) * s.wrenches.robot.torque.squaredNorm();
}

std::string terms(const WhyCandidate& w) {
  const auto part = [&](double term) { return w.cost > 0.0 ? 100.0 * term / w.cost : 0.0; };
  return fmt::format(
      "cost {:.4g} N^2 = partner's force {:.4g} ({:.0f} %) + his torque {:.4g} ({:.0f} %) + robot's force "
      "{:.4g} ({:.0f} %) + its torque {:.4g} ({:.0f} %)",
      w.cost, w.partner_force, part(w.partner_force), w.partner_torque, part(w.partner_torque), w.robot_force,
      part(w.robot_force), w.robot_torque, part(w.robot_torque));
}

// the term in which it loses most against the chosen one
std::string dearest(const WhyCandidate& w, const WhyCandidate& best) {
  const std::pair<double, const char*> more[] = {
      {w.partner_force - best.partner_force, "the partner's force"},
      {w.partner_torque - best.partner_torque, "torque in the partner's hand"},
      {w.robot_force - best.robot_force, "the robot's force"},
      {w.robot_torque - best.robot_torque, "torque in the robot's hand"}};
  const auto* most = std::max_element(std::begin(more), std::end(more));
  return most->second;
}

}  // namespace

hal::Result<WhyCandidate> explain_candidate(const control::Outcome& o, const control::Config& config,
                                            int id) {
  const auto found = std::find_if(o.candidates.begin(), o.candidates.end(),
                                  [&](const planner::GraspCandidate& c) { return c.id == id; });
  if (found == o.candidates.end()) {
    int low = 0, high = -1;
    for (const auto& c : o.candidates) low = std::min(low, c.id), high = std::max(high, c.id);
    return hal::failure(hal::ErrorCode::BadInput, "--why",
                        o.candidates.empty()
                            ? fmt::format("there is no candidate {}: the object offers none", id)
                            : fmt::format("there is no candidate {}; ids are {} to {}", id, low, high));
  }
  WhyCandidate why;
  why.index = static_cast<std::size_t>(found - o.candidates.begin());
  const planner::GraspCandidate& c = *found;
  const auto& scores = o.decision.scores;
  why.text = fmt::format("candidate {} ({}, {:.0f} mm wide, verdict {})\n", id, planner::name_of(c.kind),
                         1e3 * c.width, word(c.verdict));
  why.scored = why.index < scores.size() && scores[why.index].has_value();
  if (why.scored) {
    const planner::ScoredCandidate& s = *scores[why.index];
    cost_weight(s, config.decision.weights, why);
    why.cost = s.cost;
    why.share = s.share;
    why.from_optimum_m = (c.position - o.decision.optimum).norm();
    why.text += fmt::format("  for {:.1f} kg: {}\n", config.decision.mass_kg, terms(why));
    why.text += fmt::format("  the robot would carry {:.0f} % of the load, {:.0f} mm from the optimum\n",
                            100 * s.share, 1e3 * why.from_optimum_m);
  } else {
    why.text += "  no cost: without a partner's grasp there is nothing to share\n";
  }
  if (c.stability)
    why.text += fmt::format("  the load may grow {:.1f} times before it slips\n", *c.stability);

  for (std::size_t i = 0; i < o.candidates.size() && i < scores.size(); ++i) {
    if (!possible(o.candidates[i]) || !scores[i]) continue;
    ++why.possible;
    if (why.scored && possible(c) &&
        (scores[i]->cost < why.cost || (scores[i]->cost == why.cost && i <= why.index)))
      ++why.rank;
  }
  if (c.verdict == Verdict::Chosen) {
    why.text += fmt::format("feasible, and the lowest cost of {} candidates\n", why.possible);
  } else if (!possible(c)) {
    why.text += fmt::format("  against it: {}\n", c.reason);
  }
  if (o.decision.chosen && why.scored && *o.decision.chosen != why.index) {
    WhyCandidate best;
    const planner::ScoredCandidate& s = *scores[*o.decision.chosen];
    cost_weight(s, config.decision.weights, best);
    best.cost = s.cost;
    const double more = best.cost > 0.0 ? 100.0 * (why.cost / best.cost - 1.0) : 0.0;
    if (possible(c))
      why.text += fmt::format(
          "  against it: it is number {} of {} possible ones and costs {:.2g} % more, mostly for {}\n",
          why.rank, why.possible, more, dearest(why, best));
    else
      why.text += fmt::format("  its cost would be {:.2g} % {} than the chosen one's\n", std::abs(more),
                              more >= 0.0 ? "more" : "less");
    why.text += fmt::format("  the chosen one, {}: {}\n", o.candidates[*o.decision.chosen].id, terms(best));
  }
  return why;
}

std::string with_why(const std::string& document, const control::Outcome& outcome, const WhyCandidate& why) {
  auto doc = nlohmann::ordered_json::parse(document, nullptr, false);
  if (doc.is_discarded()) return document;
  const planner::GraspCandidate& c = outcome.candidates[why.index];
  nlohmann::ordered_json j = {{"candidate", c.id}, {"verdict", word(c.verdict)}, {"text", why.text}};
  if (!c.reason.empty()) j["because"] = c.reason;
  if (why.scored) {
    j["cost"] = why.cost;
    j["share"] = why.share;
    j["terms"] = {{"partner_force", why.partner_force},
                  {"partner_torque", why.partner_torque},
                  {"robot_force", why.robot_force},
                  {"robot_torque", why.robot_torque}};
    j["from_optimum_m"] = why.from_optimum_m;
  }
  j["rank"] = why.rank > 0 ? nlohmann::ordered_json(why.rank) : nlohmann::ordered_json(nullptr);
  j["possible"] = why.possible;
  doc["why"] = std::move(j);
  return doc.dump();
}

}  // namespace colift::tools
