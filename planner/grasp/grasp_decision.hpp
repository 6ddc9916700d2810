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
  bool share_first = true;
  double share_window = 0.02;
  std::optional<double> share_strict;
  double share_sure = 0.15;
  double partner_load_n = 245.0;
  std::optional<double> known_mass_kg;
  double grip_torque_nm = 1.0;
  double ask_gain = 0.1;
  double ask_height_m = 0.15;
  double usual_mass_kg = 4.0;
  SharingWeights weights;
  SharingLimits limits;
  double mass_kg = 1.0;
  double near_partner_m = 0.15;
  double max_sideways = 0.2;
  double max_press = 0.05;
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
      "the two, the one that was set last counts. ~: weights.epsilon.");
    v("share_first", share_first,
      "Whether a wanted share is weighed before the cost: of the candidates near the reachable share that is "
      "nearest to it, the one of lowest cost is chosen. The thesis's rule weighs the cost alone.");
    v("share_window", share_window, hal::kFraction,
      "Max difference of a candidate's share from that nearest one, and max error of a share that counts as "
      "wished, both as a fraction of the load.");
    v("share_strict", share_strict, hal::kFraction,
      "Max deviation of the predicted share from the wanted one; beyond it nothing is chosen. ~: none.");
    v("share_sure", share_sure, hal::kFraction,
      "Max half width of the prediction's 95 % interval with which a share may count as wished.");
    v("partner_load_n", partner_load_n, hal::kPositive,
      "Max vertical load of the partner (N), where the mass is known. 245 N: the 25 kg of ISO 11228-1, its "
      "reference mass for adults under ideal conditions (close to the body, between knuckle and elbow "
      "height, seldom), for one person, not scaled by posture, distance, frequency or team. Where these are "
      "worse, set less.");
    v.or_infinite("partner_load_n");
    v("known_mass_kg", known_mass_kg, hal::kPositive,
      "Mass of the object where somebody knows it (kg), for partner_load_n. ~: unknown; then it is "
      "compared in the lift, by the load in the hand and the predicted share.");
    v("grip_torque_nm", grip_torque_nm, hal::kNotNegative,
      "Standard deviation of the torque with which hands resist a tilt of the object, in the interval of the "
      "predicted share (N m).");
    v("usual_mass_kg", usual_mass_kg, hal::kPositive,
      "Mass that this torque is compared with where the object's is not known (kg).");
    v("ask_gain", ask_gain, hal::kFraction,
      "Min part of the effort of both that another place saves for which the partner is asked to go there.");
    v("ask_height_m", ask_height_m, hal::Range{0, 2},
      "Max height difference of that place from where he holds it now: a table is not carried by its feet "
      "(m).");
    v("weights", weights, "Cost weights of effort, thesis eq. 4.5.");
    v("limits", limits, "What either agent can exert; without entries there is no limit.");
    v("mass_kg", mass_kg, hal::kPositive,
      "Mass that the limits are checked for; the choice without limits does not depend on it.");
    v("near_partner_m", near_partner_m, hal::kNotNegative,
      "Min distance between the partner's grasp and the robot's (m).");
    v("max_sideways", max_sideways, hal::kNotNegative,
      "Max sideways force of the partner, as a fraction of the weight.");
    v("max_press", max_press, hal::kNotNegative,
      "Max force with which either hand has to press the object down because the centre of gravity does not "
      "lie between them (a share below 0 or above 1 by the lever rule), as a fraction of the weight.");
    v("max_lever_m", max_lever_m, hal::kPositive,
      "Max distance of the centre of gravity from the vertical plane through both hands; beyond it the "
      "object tips about the line between them; after a test lift test_lift.max_lever_m (m).");
    v.or_infinite("max_sideways");
    v.or_infinite("max_press");
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
      "of gravity and partner, with mass_kg and with grips that slip.");
    v("unevenness", unevenness, hal::kFraction,
      "Standard deviation of the centre of gravity from uneven density, as a fraction of the object's size.");
    v("what_ifs", what_ifs, hal::Range{2, 1e6}, "Number of these samples.");
  }
};

/// How the load is shared if the robot takes one candidate.
struct ScoredCandidate {
  double cost = 0.0;       ///< Thesis eq. 4.5 for a lift of mass_kg (N^2).
  double share = 0.0;      ///< The robot's part of the load by the lever rule (share_choice.hpp), 0 to 1.
  AgentWrenches wrenches;  ///< Of both agents at the top of the lift, each about its own grasp point, in W.
};

/// Which candidate is chosen, and how each one scored.
struct Decision {
  std::optional<std::size_t> chosen;  ///< Index into the candidates.
  double share = 0.0;                 ///< Of the chosen one.
  double cost = 0.0;
  Vec3 optimum = Vec3::Zero();  ///< Where the robot would best take hold if it could do so anywhere (W, m).
  std::vector<std::optional<ScoredCandidate>>
      scores;  ///< One per candidate; unset where nothing can be computed.
  /// Where a share is wanted: that of all feasible candidates which is nearest to it.
  std::optional<double> nearest_share;
  bool refused_for_share = false;  ///< Grasps are feasible, but none within share_strict.
  std::string reason;              ///< Why this one, or why none, as a person would say it.
};

/// What the decision rests on. Frame W, SI units.
struct DecisionInput {
  perception::PartnerGrasp partner;
  Vec3 cog = Vec3::Zero();
  Vec3 up = Vec3::UnitZ();
  bool base_frame_known = false;  ///< W is the robot base, so reach can be judged.
  /// Of the object, where it is known or was measured; else config.known_mass_kg.
  std::optional<double> mass_kg = {};
};

/// Scores every candidate that is still Ok, refuses those that are too near the partner, out of reach or over
/// a limit, and marks the cheapest one Chosen (thesis eq. 4.8 for the lift, section 5.3.4). Ties go to the
/// lower index. Where a share is wanted (config.share, share_first), the cheapest of those whose share is
/// nearest to it (share_choice.hpp). Errors: BadConfig when the weights or limits are not usable.
[[nodiscard]] hal::Result<Decision> decide_grasp(std::vector<GraspCandidate>& candidates,
                                                 const DecisionInput& input, const DecisionConfig& config);

/// Where the robot would best take hold for a pure lift, anywhere in space (W, m): on the line from the
/// partner through the centre of gravity.
[[nodiscard]] hal::Result<Vec3> best_robot_position(const DecisionInput& input, const DecisionConfig& config);

}  // namespace colift::planner
