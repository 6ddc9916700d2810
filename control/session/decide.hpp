#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "control/session/scene_analysis.hpp"
#include "control/session/share_contract.hpp"
#include "planner/grasp/grasp_decision.hpp"
#include "planner/grasp/robust_choice.hpp"

namespace colift::control {

/// How the partner's grasp is known: given as a point, or seen in a second frame of the same fixed camera.
struct PartnerInput {
  std::optional<hal::Vec3> position_W;
  std::optional<hal::DepthFrame> frame;
};

/// What was decided, with every candidate's verdict. Without a partner or a target nothing is chosen.
struct Outcome {
  std::optional<perception::PartnerGrasp> partner;
  std::vector<std::uint32_t> partner_pixels;  ///< Changed pixels near the object, ascending.
  std::string partner_reason;
  std::vector<planner::GraspCandidate>
      candidates;  ///< Those of the look, and some around the closed-form optimum.
  planner::Decision decision;
  ShareContract share;  ///< Of the load: wanted, reachable, predicted.
  double partner_ms = 0.0, decision_ms = 0.0;
};

/// Sees where the partner holds the object and decides where the robot takes hold of it.
/// Errors: BadInput (second frame of another size), BadConfig (weights or limits), and look()'s.
[[nodiscard]] hal::Result<Outcome> decide(const SceneAnalysis& analysis, const PartnerInput& partner,
                                          const Config& config, const hal::Clock& clock);

/// What a robust choice rests on: the belief and covariances of a look and a partner, that of the centre of
/// gravity widened by uneven density, config.unevenness of the completed box along its axes. Needs a target.
[[nodiscard]] planner::UncertainScene uncertain_scene(const SceneAnalysis& analysis,
                                                      const perception::PartnerGrasp& partner,
                                                      const planner::DecisionConfig& config);

/// Judges candidates that are made on demand, around the optimum: sets to Unreachable what the arm cannot do.
using Judge = std::function<void(std::vector<planner::GraspCandidate>&)>;

/// Adds candidates where fewer than `config.min_in_reach` are feasible: on other sides of bars, and at
/// smaller steps.
void add_grasps(SceneAnalysis& analysis, const planner::CandidateConfig& config, const Judge& judge_reach);

/// The decision for a partner who is known: candidates of the look, and some around the closed-form optimum
/// (config.candidates.refine_lines) and the best one (refine_steps), judged by `judge_more`. `mass_kg`: of
/// the object, where the caller knows or measured it. Errors: BadConfig (weights or limits), BadInput (the
/// partner's grasp is not finite, or its covariance is none).
[[nodiscard]] hal::Result<Outcome> decide_for(const SceneAnalysis& analysis,
                                              const perception::PartnerGrasp& partner, const Config& config,
                                              const hal::Clock& clock, const Judge& judge_more = {},
                                              std::optional<double> mass_kg = {});

/// Takes another candidate of an outcome than the decision did: verdicts, cost and share follow; `reason` is
/// said of it. Errors: BadInput, and nothing changes, where that candidate is not feasible or nothing was
/// chosen.
hal::Result<> choose_instead(Outcome& outcome, std::size_t candidate, std::string reason);

}  // namespace colift::control
