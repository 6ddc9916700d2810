#pragma once

#include <optional>
#include <string>
#include <vector>

#include "hal/config/range.hpp"
#include "hal/types/result.hpp"
#include "perception/scene.hpp"
#include "planner/grasp_candidate.hpp"
#include "planner/load_sharing/load_limits.hpp"
#include "planner/load_sharing/load_sharing.hpp"

namespace colift::planner {

/// Weights and limits of the decision, and what is refused before it.
struct DecisionConfig {
  std::optional<double> share;  ///< What weights.epsilon was made of, where a person said it so.
  SharingWeights weights;
  SharingLimits limits;
  double mass_kg = 1.0;
  double near_partner_m = 0.15;
  double max_sideways = 0.2;
  double max_lever_m = 10.0;
  bool check_reach = true;
  Vec3 shoulder_m{0.0, 0.0, 0.3105};
  double arm_reach_m = 0.79;
  double wrist_to_palm_m = 0.137;
  std::string robust = "nominal";
  double unevenness = 0.05;
  int what_ifs = 10'000;

  template <class Visitor>
  void visit(Visitor& v) {
    v("share", share, hal::kFraction,
      "Share of the load that the robot shall carry, more than 0 and less than 1; sets weights.epsilon. Of "
      "the "
      "two, the one that was set last counts. ~: weights.epsilon.");
    v("weights", weights, "Cost weights of effort, thesis eq. 4.5.");
    v("limits", limits, "What either agent can exert; without entries there is no limit.");
    v("mass_kg", mass_kg, hal::kPositive,
      "Mass that the limits are checked for; the choice without limits does not depend on it.");
    v("near_partner_m", near_partner_m, hal::kNotNegative,
      "Min distance between the partner's grasp and the robot's (m).");
    v("max_sideways", max_sideways, hal::kNotNegative,
      "Max sideways force of the partner, as a fraction of the weight.");
    v("max_lever_m", max_lever_m, hal::kPositive,
      "Max distance of the centre of gravity from the vertical plane through both hands; beyond it the "
      "object tips about the line between them (m).");
    v.or_infinite("max_sideways");
    v.or_infinite("max_lever_m");
    v("check_reach", check_reach,
      "Whether a grasp beyond the arm's reach is refused (needs the camera's pose).");
    v("shoulder_m", shoulder_m, hal::Range{-10, 10},
      "Intersection of axes 1 to 3 of the arm, in the robot base frame (m).");
    v("arm_reach_m", arm_reach_m, hal::kPositive,
      "Max distance of the wrist from the shoulder: upper arm and forearm in line (m).");
    v("wrist_to_palm_m", wrist_to_palm_m, hal::kNotNegative,
      "Distance from the wrist's centre to the palm along the approach (m).");
    v("robust", robust, hal::Choices{"nominal", "expected", "worst"},
      "Which cost the choice minimises: the nominal one, or the expected or the worst over samples of centre "
      "of "
      "gravity and partner, with mass_kg and with grips that slip.");
    v("unevenness", unevenness, hal::kFraction,
      "Standard deviation of the centre of gravity from uneven density, as a fraction of the object's size.");
    v("what_ifs", what_ifs, hal::Range{2, 1e6}, "Number of these samples.");
  }
};

/// How the load is shared if the robot takes one candidate.
struct ScoredCandidate {
  double cost = 0.0;       ///< Thesis eq. 4.5 for a lift of mass_kg (N^2).
  double share = 0.0;      ///< The robot's part of the load, 0 to 1.
  AgentWrenches wrenches;  ///< Of both agents at the top of the lift, each about its own grasp point, in W.
};

/// Which candidate is chosen, and how each one scored.
struct Decision {
  std::optional<std::size_t> chosen;  ///< Index into the candidates.
  double share = 0.0;                 ///< Of the chosen one.
  double cost = 0.0;
  Vec3 optimum = Vec3::Zero();  ///< Where the robot would best take hold if it could do so anywhere (W, m).
  std::vector<std::optional<ScoredCandidate>>
      scores;          ///< One per candidate; unset where nothing can be computed.
  std::string reason;  ///< Why this one, or why none, as a person would say it.
};

/// What the decision rests on. Frame W, SI units.
struct DecisionInput {
  perception::PartnerGrasp partner;
  Vec3 cog = Vec3::Zero();
  Vec3 up = Vec3::UnitZ();
  bool base_frame_known = false;  ///< W is the robot base, so reach can be judged.
};

/// Scores every candidate that is still Ok, refuses those that are too near the partner, out of reach or over
/// a limit, and marks the cheapest one Chosen (thesis eq. 4.8 for the lift, section 5.3.4). Ties go to the
/// lower index. Errors: BadConfig when the weights or limits are not usable.
[[nodiscard]] hal::Result<Decision> decide_grasp(std::vector<GraspCandidate>& candidates,
                                                 const DecisionInput& input, const DecisionConfig& config);

/// Where the robot would best take hold for a pure lift, anywhere in space (W, m): on the line from the
/// partner through the centre of gravity.
[[nodiscard]] hal::Result<Vec3> best_robot_position(const DecisionInput& input, const DecisionConfig& config);

}  // namespace colift::planner
