#include "planner/grasp/grasp_decision.hpp"
#include "hal/types/units.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "planner/grasp/grasp_candidates.hpp"
#include "planner/grasp/share_choice.hpp"

namespace colift::planner {
namespace {

void refuse(GraspCandidate& c, Verdict verdict, std::string why) {
  c.verdict = verdict;
  c.reason = std::move(why);
}

// how far the centre of gravity lies beside the vertical plane through both hands (m)
double lever_of(const GraspCandidate& c, const DecisionInput& in) {
  const Vec3 line = load_point(c) - in.partner.position;
  const Vec3 level = line - in.up * in.up.dot(line);
  if (level.norm() < 1e-6) return 0.0;
  return std::abs((in.cog - in.partner.position).dot(in.up.cross(level.normalized())));
}

// what speaks against a candidate before any load is computed
void judge_geometry(GraspCandidate& c, const DecisionInput& in, const DecisionConfig& config) {
  const double gap = (c.position - in.partner.position).norm();
  if (gap < config.near_partner_m) {
    return refuse(c, Verdict::NearPartner,
                  fmt::format("{:.0f} mm from the partner's hand (min {:.0f} mm)", 1e3 * gap,
                              1e3 * config.near_partner_m));
  }
  if (const double lever = lever_of(c, in); lever > config.max_lever_m) {
    return refuse(c, Verdict::Unstable,
                  fmt::format("the object would tip: its centre of gravity lies {:.0f} mm beside the line "
                              "between both hands (max {:.0f} mm)",
                              1e3 * lever, 1e3 * config.max_lever_m));
  }
  if (in.base_frame_known && config.check_reach) {
    const double reach = (c.position - config.wrist_to_palm_m * c.approach - config.shoulder_m).norm();
    if (reach > config.arm_reach_m) {
      return refuse(c, Verdict::Unreachable,
                    fmt::format("the wrist would be {:.2f} m from the shoulder, the arm reaches {:.2f} m",
                                reach, config.arm_reach_m));
    }
  }
}

// the torque that both hands together have to hold, beside their forces (N m)
double torque_of(const AgentWrenches& w) {
  return w.partner.torque.norm() + w.robot.torque.norm();
}

std::string reason(const std::vector<GraspCandidate>& candidates, const Decision& d, const DecisionInput& in,
                   const DecisionConfig& config) {
  const GraspCandidate& best = candidates[*d.chosen];
  const ScoredCandidate& s = *d.scores[*d.chosen];
  std::string text = fmt::format(
      "candidate {} carries {:.0f} % of the load with {:.2f} N m of torque in both hands per kilogram "
      "lifted, {:.0f} mm from the optimum",
      best.id, 100 * s.share, torque_of(s.wrenches) / config.mass_kg,
      1e3 * (best.position - d.optimum).norm());
  std::size_t ok = 1;
  const ScoredCandidate* next = nullptr;
  int next_id = 0;
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    if (i == *d.chosen || candidates[i].verdict != Verdict::Ok || !d.scores[i]) continue;
    ++ok;
    if (!comes_near_share(d, i, config)) continue;
    if (!next || d.scores[i]->cost < next->cost) {
      next = &*d.scores[i];
      next_id = candidates[i].id;
    }
  }
  if (next) {
    const double more = 100 * (next->cost / s.cost - 1);
    text += fmt::format("; {} candidates were possible, the next best ({}) costs {:.{}f} % more", ok, next_id,
                        more, more < 10 ? 1 : 0);
  } else if (ok > 1) {
    text += fmt::format("; {} candidates were possible, no other one comes so near to the wanted share", ok);
  } else {
    text += "; no other candidate was possible";
  }
  const double lever = (in.partner.position - in.cog).cross(in.up).norm();
  return text + fmt::format("; the partner holds {:.2f} m beside the centre of gravity", lever);
}

// how many candidates fell to what, and of each kind the one that came nearest
std::string why_none(const std::vector<GraspCandidate>& candidates, const Vec3& optimum,
                     const DecisionInput& in, const DecisionConfig& config) {
  if (candidates.empty()) return "no grasp: the object offers no candidate";
  std::string text = fmt::format("no grasp: of {} candidates", candidates.size());
  const char* separator = " ";
  for (const Refusals& group : refusals(candidates)) {
    text += fmt::format("{}{} {} (candidate {}: {})", separator, group.count, group.why, group.nearest->id,
                        group.nearest->reason);
    separator = ", ";
  }
  if (!in.base_frame_known || !config.check_reach) return text;
  const double beyond = (optimum - config.shoulder_m).norm() - config.arm_reach_m - config.wrist_to_palm_m;
  if (beyond <= 0.0) return text;
  return text + fmt::format(
                    "; opposite of the partner, at ({:.2f}, {:.2f}) m, the load would be shared best, "
                    "but that is {:.2f} m beyond the reach of the hand",
                    optimum.x(), optimum.y(), beyond);
}

}  // namespace

hal::Result<Vec3> best_robot_position(const DecisionInput& input, const DecisionConfig& config) {
  const auto sharing = LoadSharing::create(config.weights);
  if (!sharing) return tl::unexpected(sharing.error());
  return Vec3(input.cog + sharing->best_robot_position(input.partner.position - input.cog));
}

hal::Result<Decision> decide_grasp(std::vector<GraspCandidate>& candidates, const DecisionInput& input,
                                   const DecisionConfig& config) {
  const auto sharing = LoadSharing::create(config.weights);
  if (!sharing) return tl::unexpected(sharing.error());
  const auto limited = LimitedSharing::create(*sharing, config.limits);
  if (!limited) return tl::unexpected(limited.error());

  const Vec3 partner = input.partner.position - input.cog;
  const Wrench lift{config.mass_kg * hal::kGravity_m_s2 * input.up, Vec3::Zero()};
  const std::optional<double> mass_kg = input.mass_kg ? input.mass_kg : config.known_mass_kg;
  Decision d;
  d.optimum = input.cog + sharing->best_robot_position(partner);
  d.scores.resize(candidates.size());
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    GraspCandidate& c = candidates[i];
    const Vec3 robot = load_point(c) - input.cog;
    if (c.verdict == Verdict::Ok) judge_geometry(c, input, config);
    auto wrenches = limited->wrenches(partner, robot, lift);
    if (!wrenches && c.verdict == Verdict::Ok) {
      const auto shortfall = limited->shortfall(partner, robot, lift);
      refuse(c, Verdict::OverLimit,
             shortfall ? shortfall->text() : "the load is beyond what both agents can exert");
    }
    // a candidate that is over a limit still shows what it would take
    if (!wrenches) wrenches = sharing->wrenches(partner, robot, lift);
    const double share = lever_share(input.cog, input.partner.position, load_point(c), input.up)
                             .value_or(wrenches->robot.force.dot(lift.force) / lift.force.squaredNorm());
    d.scores[i] = ScoredCandidate{sharing->cost_weight(*wrenches), share, *wrenches};
    const double sideways =
        (wrenches->partner.force - wrenches->partner.force.dot(input.up) * input.up).norm() /
        lift.force.norm();
    if (c.verdict == Verdict::Ok && sideways > config.max_sideways) {
      refuse(
          c, Verdict::OverLimit,
          fmt::format("the partner would have to push sideways with {:.0f} % of the weight (limit {:.0f} %)",
                      100 * sideways, 100 * config.max_sideways));
    }
    if (const double press = std::max(share - 1.0, -share);
        c.verdict == Verdict::Ok && press > config.max_press) {
      refuse(
          c, Verdict::OverLimit,
          fmt::format("{} would have to press the object down with {:.0f} % of its weight (limit {:.0f} %)",
                      share > 1.0 ? "the partner" : "the robot", 100 * press, 100 * config.max_press));
    }
    if (c.verdict == Verdict::Ok && mass_kg) {
      const double his_n = (1.0 - share) * *mass_kg * hal::kGravity_m_s2;
      if (his_n > config.partner_load_n)
        refuse(c, Verdict::OverLimit,
               fmt::format("the partner would bear {:.0f} N of {:.1f} kg (limit {:.0f} N)", his_n, *mass_kg,
                           config.partner_load_n));
    }
  }
  if (config.share && config.share_first)
    d.nearest_share = nearest_share(candidates, d.scores, *config.share);
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    if (candidates[i].verdict != Verdict::Ok || !comes_near_share(d, i, config)) continue;
    if (d.chosen && d.scores[i]->cost >= d.cost) continue;
    d.chosen = i;
    d.cost = d.scores[i]->cost;
    d.share = d.scores[i]->share;
  }
  if (!d.chosen) {
    d.reason = why_none(candidates, d.optimum, input, config);
    return d;
  }
  if (auto refusal = too_far_from_share(d.share, config)) {
    d.reason = *std::move(refusal);
    d.refused_for_share = true;
    d.chosen.reset();
    return d;
  }
  d.reason = reason(candidates, d, input, config);
  candidates[*d.chosen].verdict = Verdict::Chosen;
  candidates[*d.chosen].reason = d.reason;
  return d;
}

}  // namespace colift::planner
