#include "control/session/decide.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "control/session/pipeline.hpp"
#include "hal/types/symmetric.hpp"
#include "hal/types/units.hpp"
#include "perception/partner/partner_grasp.hpp"
#include "planner/grasp/grasp_stability.hpp"
#include "planner/grasp/share_choice.hpp"

namespace colift::control {
namespace {

using perception::PartnerGrasp;

hal::Result<> find_partner(const SceneAnalysis& analysis, const PartnerInput& input, const Config& c,
                           Outcome& out) {
  if (input.position_W) {
    out.partner = PartnerGrasp{*input.position_W, Eigen::Matrix3d::Zero(), 0, {}};
    out.partner_reason = "the partner's grasp was given";
    return {};
  }
  if (!input.frame)
    return hal::failure(hal::ErrorCode::BadInput, "partner", "neither a position nor a frame was given");
  if (input.frame->depth_m.size() != analysis.frame.depth_m.size()) {
    return hal::failure(
        hal::ErrorCode::BadInput, "partner",
        fmt::format("the second frame has {} pixels, the first {}; both have to come from the same camera",
                    input.frame->depth_m.size(), analysis.frame.depth_m.size()));
  }
  const auto pipeline = make_pipeline(analysis.method);
  if (!pipeline) return tl::unexpected(pipeline.error());
  auto seen = (*pipeline)->find_partner(analysis, *input.frame, c);
  if (!seen) return tl::unexpected(seen.error());
  out.partner = seen->grasp;
  out.partner_pixels = std::move(seen->pixels);
  out.partner_reason = std::move(seen->reason);
  return {};
}

constexpr std::size_t kAtOnce = 512;  // candidates; more are taken in turns

// a caller's estimate may hold anything
bool is_belief(const PartnerGrasp& p) {
  constexpr double kRounding = 1e-9;
  if (!p.position.allFinite() || !p.covariance.allFinite()) return false;
  const double size = p.covariance.norm();
  if ((p.covariance - p.covariance.transpose()).norm() > kRounding * size) return false;
  return hal::small_symmetric_eigen(p.covariance).values[0] >= -kRounding * size;
}

double sigma_mm(const Eigen::Matrix3d& covariance) {
  return 1e3 * std::sqrt(std::max(0.0, covariance.diagonal().maxCoeff()));
}

// The weight that each candidate lifts before it slips, straight up (N).
std::vector<double> holds(const std::vector<planner::GraspCandidate>& candidates,
                          const planner::HandModel& hand, const planner::UncertainScene& scene) {
  std::vector<double> out;
  out.reserve(candidates.size());
  const hal::Wrench load{-scene.weight_n * scene.up, hal::Vec3::Zero()};
  for (const planner::GraspCandidate& c : candidates)
    out.push_back(scene.weight_n * planner::stability_margins(c, hand, load).slip);
  return out;
}

// The nominal choice in, that over the what-ifs out.
hal::Result<> choose_robustly(const SceneAnalysis& analysis, const planner::DecisionConfig& config,
                              Outcome& out) {
  planner::Decision& d = out.decision;
  if (config.robust == "nominal" || !d.chosen) return {};
  const planner::UncertainScene scene = uncertain_scene(analysis, *out.partner, config);
  auto robust = planner::RobustChoice::create(config.weights, kAtOnce, config.what_ifs);
  if (!robust) return tl::unexpected(robust.error());
  const bool worst = config.robust == "worst";
  std::vector<planner::GraspCandidate> near_share = out.candidates;
  for (std::size_t i = 0; i < near_share.size(); ++i)
    if (!planner::comes_near_share(d, i, config)) near_share[i].verdict = planner::Verdict::OverLimit;
  const auto best = robust->choose(
      scene, near_share, worst ? planner::RobustChoice::Aim::Worst : planner::RobustChoice::Aim::Expected,
      holds(out.candidates, analysis.finder->hand(), scene));
  const std::string over = fmt::format(
      "over {} what-ifs (centre of gravity +- {:.0f} mm, partner +- {:.0f} mm, {:.1f} kg)", config.what_ifs,
      sigma_mm(scene.cog_covariance), sigma_mm(scene.partner_covariance), config.mass_kg);
  planner::GraspCandidate& before = out.candidates[*d.chosen];
  if (!best || *best == *d.chosen) {
    d.reason += "; the same " + over;
    before.reason = d.reason;
    return {};
  }
  planner::GraspCandidate& after = out.candidates[*best];
  const planner::ScoredCandidate& score = *d.scores[*best];
  d.reason = fmt::format(
      "candidate {} has the lowest cost {} {} and carries {:.0f} % of the load; with what is "
      "believed it would be {}: {}",
      after.id, worst ? "at worst" : "on average", over, 100 * score.share, before.id, d.reason);
  return choose_instead(out, *best, d.reason);
}

// out.candidates and out.partner in, the rest out
hal::Result<> choose(const SceneAnalysis& analysis, const Config& config, const hal::Clock& clock,
                     const Judge& judge_more, std::optional<double> mass_kg, Outcome& out) {
  const hal::Timestamp start = clock.now();
  const planner::DecisionInput input{*out.partner, analysis.scene.target->cog,
                                     analysis.scene.ground->plane.normal, analysis.base_frame_known, mass_kg};
  if (config.candidates.refine_lines > 0 && !analysis.own_candidates) {
    // the list is coarse; what matters lies around the closed-form optimum
    const auto best = planner::best_robot_position(input, config.decision);
    if (!best) return tl::unexpected(best.error());
    auto more = analysis.finder->near(*best, out.candidates);
    if (judge_more) judge_more(more);
    out.candidates.insert(out.candidates.end(), more.begin(), more.end());
  }
  const std::vector<planner::GraspCandidate> possible = out.candidates;
  auto decision = planner::decide_grasp(out.candidates, input, config.decision);
  if (!decision) return tl::unexpected(decision.error());
  if (decision->chosen && config.candidates.refine_steps > 0 && !analysis.own_candidates) {
    auto more = analysis.finder->around(out.candidates[*decision->chosen], possible);
    if (judge_more) judge_more(more);
    out.candidates = possible;
    out.candidates.insert(out.candidates.end(), more.begin(), more.end());
    decision = planner::decide_grasp(out.candidates, input, config.decision);
    if (!decision) return tl::unexpected(decision.error());
  }
  out.decision = std::move(*decision);
  if (auto done = choose_robustly(analysis, config.decision, out); !done) return tl::unexpected(done.error());
  out.share = share_contract(out, analysis, uncertain_scene(analysis, *out.partner, config.decision), config,
                             mass_kg);
  say_share(out);
  refuse_beyond_limits(out, config.certificate);
  out.decision_ms = 1e3 * hal::seconds(clock.now() - start);
  return {};
}

}  // namespace

void add_grasps(SceneAnalysis& analysis, const planner::CandidateConfig& config, const Judge& judge_reach) {
  constexpr double kSmallest_m = 0.012;  // half a fingertip's width
  if (!analysis.finder) return;
  std::vector<planner::GraspCandidate>& all = analysis.candidates;
  const auto possible = [&] {
    return std::count_if(all.begin(), all.end(),
                         [](const auto& c) { return c.verdict == planner::Verdict::Ok; });
  };
  for (double step = config.step_m; step >= kSmallest_m && possible() < config.min_in_reach; step *= 0.5) {
    auto more = analysis.finder->between(step, all);
    judge_reach(more);
    all.insert(all.end(), more.begin(), more.end());
  }
}

hal::Result<> choose_instead(Outcome& outcome, std::size_t candidate, std::string reason) {
  planner::Decision& d = outcome.decision;
  const auto refuse = [&](std::string detail) {
    return hal::failure(hal::ErrorCode::BadInput, fmt::format("choice of candidate {}", candidate),
                        std::move(detail));
  };
  if (!d.chosen) return refuse("there is nothing to choose among: " + d.reason);
  if (candidate >= outcome.candidates.size() || candidate >= d.scores.size())
    return refuse(fmt::format("there are {} candidates", outcome.candidates.size()));
  planner::GraspCandidate& after = outcome.candidates[candidate];
  if (after.verdict == planner::Verdict::Chosen) return {};
  if (after.verdict != planner::Verdict::Ok) return refuse("it is not feasible: " + after.reason);
  if (!d.scores[candidate]) return refuse("it has no cost");
  planner::GraspCandidate& before = outcome.candidates[*d.chosen];
  before.verdict = planner::Verdict::Ok;
  before.reason.clear();
  after.verdict = planner::Verdict::Chosen;
  after.reason = d.reason = std::move(reason);
  d.chosen = candidate;
  d.cost = d.scores[candidate]->cost;
  d.share = d.scores[candidate]->share;
  return {};
}

planner::UncertainScene uncertain_scene(const SceneAnalysis& analysis, const PartnerGrasp& partner,
                                        const planner::DecisionConfig& config) {
  const perception::Target& target = *analysis.scene.target;
  const hal::Vec3 uneven = config.unevenness * target.shape.size;
  planner::UncertainScene scene;
  scene.cog = target.cog;
  scene.cog_covariance = target.cog_covariance +
                         target.shape.axes * uneven.cwiseAbs2().asDiagonal() * target.shape.axes.transpose();
  scene.partner = partner.position;
  scene.partner_covariance = partner.covariance;
  scene.up = analysis.scene.ground->plane.normal;
  scene.weight_n = hal::kGravity_m_s2 * config.mass_kg;
  return scene;
}

hal::Result<Outcome> decide(const SceneAnalysis& analysis, const PartnerInput& partner, const Config& config,
                            const hal::Clock& clock) {
  Outcome out;
  out.candidates = analysis.candidates;
  if (!analysis.scene.target) {
    out.decision.reason = analysis.reason;
    out.partner_reason = "there is no target that a partner could hold";
    return out;
  }
  const hal::Timestamp start = clock.now();
  if (auto seen = find_partner(analysis, partner, config, out); !seen) return tl::unexpected(seen.error());
  out.partner_ms = 1e3 * hal::seconds(clock.now() - start);
  if (!out.partner) {
    out.decision.reason = "no decision without the partner's grasp: " + out.partner_reason;
    return out;
  }
  if (auto done = choose(analysis, config, clock, {}, {}, out); !done) return tl::unexpected(done.error());
  return out;
}

hal::Result<Outcome> decide_for(const SceneAnalysis& analysis, const PartnerGrasp& partner,
                                const Config& config, const hal::Clock& clock, const Judge& judge_more,
                                std::optional<double> mass_kg) {
  if (!is_belief(partner))
    return hal::failure(hal::ErrorCode::BadInput, "partner",
                        "the grasp is no estimate; expected a finite position and a covariance that is "
                        "symmetric and has no negative variance");
  Outcome out;
  out.candidates = analysis.candidates;
  out.partner = partner;
  out.partner_reason = "the partner's hand rests on the object";
  if (auto done = choose(analysis, config, clock, judge_more, mass_kg, out); !done)
    return tl::unexpected(done.error());
  return out;
}

}  // namespace colift::control
