#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "control/test_lift/cog_belief.hpp"
#include "hal/config/range.hpp"
#include "hal/types/geometry.hpp"
#include "hal/types/result.hpp"
#include "planner/grasp_candidate.hpp"

namespace colift::control {

/// A slow lift of some millimetres, which ends as soon as it has told what there is to tell.
struct TestLiftConfig {
  bool on = false;
  double height_m = 0.03;
  double raise_s = 15.0;
  double hold_s = 1.0;
  double slow_turn_deg = 0.8;
  double slow_fraction = 0.2;
  double good_turn_deg = 1.5;
  double max_turn_deg = 1.75;
  double max_drift_deg_s = 0.2;
  double max_share_error = 0.10;
  double min_load_n = 2.0;
  int grips = 4;
  double min_level_probability = 0.03;
  int asks = 2;
  double min_level_probability_elsewhere = 0.2;
  double min_share = 0.15;
  double max_share = 0.85;
  int agreeing_frames = 6;
  double clear_factor = 2.0;
  double standing_turn_deg = 0.3;
  double same_grip_m = 0.02;
  double same_partner_m = 0.05;
  double level_probability_tolerance = 0.05;
  double partner_height_tolerance_m = 0.08;
  double min_hand_distance_m = 0.30;
  double tried_partner_radius_m = 0.10;
  CogBeliefConfig belief;

  template <class Visitor>
  void visit(Visitor& v) {
    v("on", on, "Whether a run makes test lifts.");
    v("height_m", height_m, hal::Range{0.002, 0.05},
      "Greatest height of a test lift (m): at max_turn_deg every foot has to be clear of the ground by "
      "then.");
    v("raise_s", raise_s, hal::Range{0.2, 30}, "Time in which that height would be reached (s).");
    v("hold_s", hold_s, hal::Range{0.1, 10}, "How long is measured at the top (s).");
    v("slow_turn_deg", slow_turn_deg, hal::Range{0.1, 10},
      "An object that has turned so far about the line between both hands is raised slowly from there "
      "(deg).");
    v.renamed("slow_part", "slow_fraction");
    v("slow_fraction", slow_fraction, hal::Range{0.05, 1}, "Part of the speed that is slow.");
    v("good_turn_deg", good_turn_deg, hal::Range{0.1, 10},
      "An object that hangs at this tilt or less is lifted on; at more, another grip is looked for (deg).");
    v("max_turn_deg", max_turn_deg, hal::Range{0.1, 10},
      "One that has turned further is raised no more, and is put down (deg).");
    v("max_drift_deg_s", max_drift_deg_s, hal::kPositive,
      "One that still turns faster at the top slips in the hand, and is put down (deg/s).");
    v("max_share_error", max_share_error, hal::kFraction,
      "Difference of the robot's share from what was predicted that is still lifted.");
    v.renamed("least_load_n", "min_load_n");
    v("min_load_n", min_load_n, hal::kNotNegative,
      "A load below this says nothing: the object stands still on the ground (N).");
    v("grips", grips, hal::Range{1, 20},
      "Places where the hand takes hold, for each place of the partner's, before it gives up.");
    v.renamed("least_chance", "min_level_probability");
    v("min_level_probability", min_level_probability, hal::kFraction,
      "A grasp is not tried when the chance that it holds the object level is below this.");
    v("asks", asks, hal::Range{0, 10},
      "How often the partner is asked to take hold elsewhere where no level grip is found.");
    v.renamed("least_chance_elsewhere", "min_level_probability_elsewhere");
    v("min_level_probability_elsewhere", min_level_probability_elsewhere, hal::kFraction,
      "For less of a chance of a level grip he is not asked.");
    v.renamed("least_share", "min_share");
    v("min_share", min_share, hal::kFraction,
      "Least part of the load that the robot should bear where he is asked to.");
    v.renamed("most_share", "max_share");
    v("max_share", max_share, hal::kFraction, "Greatest part of it: the rest is the partner's.");
    v("agreeing_frames", agreeing_frames, hal::Range{1, 100},
      "Frames in a row that have to agree on how the object is raised.");
    v("clear_factor", clear_factor, hal::Range{1, 20},
      "A test lift ends when every foot is higher than belief.clear_m by this factor.");
    v("standing_turn_deg", standing_turn_deg, hal::Range{0, 10},
      "An object on a foot that has turned by less has not moved: the hand slides on it (deg).");
    v("same_grip_m", same_grip_m, hal::Range{0, 0.5},
      "A grasp so near to one that a test lift was made at is the same (m).");
    v("same_partner_m", same_partner_m, hal::Range{0, 0.5},
      "A partner's grasp so near to an earlier one is the same: he is seen to some centimetres (m).");
    v("level_probability_tolerance", level_probability_tolerance, hal::kFraction,
      "Among grasps within this of the best probability of a level grip, the share decides.");
    v("partner_height_tolerance_m", partner_height_tolerance_m, hal::Range{0, 1},
      "Max height difference between the partner's grasp and one that he is asked for (m).");
    v("min_hand_distance_m", min_hand_distance_m, hal::Range{0, 2},
      "Min horizontal distance between his hand and the robot's where he is asked to grasp (m).");
    v("tried_partner_radius_m", tried_partner_radius_m, hal::Range{0, 1},
      "He is not asked to grasp so near to where he grasped already (m).");
    v("belief", belief, "What is believed of an object before it is lifted.");
  }
};

/// How a test lift goes on: it is enough when the object has turned too far, or every foot is well clear of
/// the ground.
enum class Raise { On, Slowly, Enough };
[[nodiscard]] Raise raise_on(const Hanging& now, const TestLiftConfig& config);

/// What a test lift says.
struct TestLift {
  Hanging seen;
  bool stands = false;  ///< A foot is on the ground and bears torque that the arm does not feel.
  bool bearable =
      false;         ///< It hangs, still, at max_turn_deg or less: to be lifted if no better grip is found.
  CogBelief belief;  ///< After this and all test lifts before it.
  double mass_kg = 0.0;
  hal::Vec3 cog = hal::Vec3::Zero();  ///< Mean of the belief; its height stays the shape's.
  double lever_m = 0.0;               ///< Of it from the line between both hands, level.
  double share = 0.0;                 ///< The robot's measured part of the weight.
  enum class Next {
    GoOn,
    OtherShare,  ///< Level, but the robot bears another part than was agreed: say so, and ask.
    Regrasp,     ///< Put down, and take hold where the belief gives the best chance (chance_level).
  } next = Next::GoOn;
  std::string because;
};

/// Mass and centre of gravity from test lifts of one object, the last of which was made just now.
///
/// An object whose centre of gravity lies beside the line between the hands turns about that line until it
/// hangs, or until feet on the heavy side stand on the ground. Only one that hangs is felt as it is
/// (weigh_cog() says what follows from either). So a test lift is raised until the camera sees that all feet
/// are clear, or that the object has turned by max_turn_deg: before it would show the whole lever. One that
/// hangs still and at good_turn_deg or less is lifted on, as slowly: its tilt does not grow with height. All
/// others are put down. Errors: NotFound (the load says nothing, or nothing that is possible fits it, with
/// the numbers), BadInput (no test lift, not finite, hands at one place, fewer than three feet).
[[nodiscard]] hal::Result<TestLift> understand_test_lift(const CarriedObject& object,
                                                         std::span<const FeltLift> tests,
                                                         const TestLiftConfig& config);

/// Of the grasps that are possible (Ok or Chosen), where the hand takes hold next while the partner holds at
/// `partner` (W): where chance_level() is best; of those that are as good to within a twentieth, the one
/// whose share is nearest to `wanted_share`. Places that a test lift was made at are left out, unless the
/// partner was elsewhere then. nullopt when no chance is as good as TestLiftConfig::min_level_probability.
struct NextGrip {
  std::size_t index = 0;  ///< Of the grasps.
  double chance = 0.0;
  double share = 0.0;  ///< What the robot would bear, by the mean of the belief.
};
[[nodiscard]] std::optional<NextGrip> next_grip(std::span<const planner::GraspCandidate> grasps,
                                                const hal::Vec3& partner, std::span<const FeltLift> tests,
                                                const CogBelief& belief, double wanted_share,
                                                const TestLiftConfig& config);

}  // namespace colift::control
