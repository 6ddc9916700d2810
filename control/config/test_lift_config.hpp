#pragma once

#include "hal/config/range.hpp"

namespace colift::control {

/// What is believed of the centre of gravity before a test lift, and how much a test lift can tell.
struct CogBeliefConfig {
  double density_sigma_m = 0.13;
  double step_m = 0.01;
  double mass_sigma = 0.25;
  double partner_nm = 0.2;
  double place_m = 0.01;
  double grip_nm_rad = 60.0;
  double grip_sigma = 0.4;
  double clear_m = 0.0015;
  double min_mass_kg = 0.2;
  double max_mass_kg = 30.0;

  template <class Visitor>
  void visit(Visitor& v) {
    v("density_sigma_m", density_sigma_m, hal::Range{0.0, 1.0},
      "How far uneven density may put the centre of gravity off the shape's, standard deviation (m).");
    v("step_m", step_m, hal::Range{0.002, 0.1}, "Distance between the places that are weighed (m).");
    v("mass_sigma", mass_sigma, hal::Range{0.01, 2.0},
      "Relative difference of the mass from one test lift to the next that is no contradiction.");
    v("partner_nm", partner_nm, hal::kNotNegative,
      "Torque of the partner's hand, which the arm does not measure (N m).");
    v("place_m", place_m, hal::kPositive, "Error of hands and feet, as seen (m).");
    v("grip_nm_rad", grip_nm_rad, hal::kPositive,
      "Rotational stiffness of the hands' hold of an object, until test lifts have estimated it (N m/rad).");
    v("grip_sigma", grip_sigma, hal::Range{0.0, 2.0}, "Relative difference of that from grasp to grasp.");
    v("min_mass_kg", min_mass_kg, hal::kPositive, "Min mass of an object that two carry by hand (kg).");
    v("max_mass_kg", max_mass_kg, hal::kPositive, "Max mass of one (kg).");
    v("clear_m", clear_m, hal::Range{0.0, 0.02}, "A foot that has risen by less may still stand (m).");
  }
};

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
  double max_lever_m = 10.0;
  CogBeliefConfig belief;

  template <class Visitor>
  void visit(Visitor& v) {
    v("on", on, "Whether a run makes test lifts.");
    v("height_m", height_m, hal::Range{0.002, 0.05},
      "Max height of a test lift (m): at max_turn_deg every foot has to be clear of the ground by "
      "then.");
    v("raise_s", raise_s, hal::Range{0.2, 30}, "Time in which that height would be reached (s).");
    v("hold_s", hold_s, hal::Range{0.1, 10}, "How long is measured at the top (s).");
    v("slow_turn_deg", slow_turn_deg, hal::Range{0.1, 10},
      "An object that has turned so far about the line between both hands is raised slowly from there "
      "(deg).");
    v("slow_fraction", slow_fraction, hal::Range{0.05, 1}, "Speed scale beyond slow_turn_deg.");
    v.renamed("slow_part", "slow_fraction");
    v("good_turn_deg", good_turn_deg, hal::Range{0.1, 10},
      "An object that hangs at this tilt or less is lifted on; at more, another grip is looked for (deg).");
    v("max_turn_deg", max_turn_deg, hal::Range{0.1, 10},
      "Max rotation: the object is not raised further and is set down (deg).");
    v("max_drift_deg_s", max_drift_deg_s, hal::kPositive,
      "One that still turns faster at the top slips in the hand, and is put down (deg/s).");
    v("max_share_error", max_share_error, hal::kFraction,
      "Difference of the robot's share from what was predicted that is still lifted.");
    v("min_load_n", min_load_n, hal::kNotNegative,
      "A load below this says nothing: the object stands still on the ground (N).");
    v.renamed("least_load_n", "min_load_n");
    v("grips", grips, hal::Range{1, 20},
      "Grasps that are tested for each grasp of the partner before the test lifts end without result.");
    v("min_level_probability", min_level_probability, hal::kFraction,
      "Min probability of a level grip for which a grasp is tried.");
    v.renamed("least_chance", "min_level_probability");
    v("asks", asks, hal::Range{0, 10},
      "How often the partner is asked to grasp elsewhere where no level grip is found.");
    v("min_level_probability_elsewhere", min_level_probability_elsewhere, hal::kFraction,
      "Min probability of a level grip for which he is asked.");
    v.renamed("least_chance_elsewhere", "min_level_probability_elsewhere");
    v("min_share", min_share, hal::kFraction,
      "Min share of the robot at a place to which the partner is asked to go.");
    v.renamed("least_share", "min_share");
    v("max_share", max_share, hal::kFraction, "Max share of the robot there; the rest is the partner's.");
    v.renamed("most_share", "max_share");
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
    v("max_lever_m", max_lever_m, hal::kPositive,
      "In place of decision.max_lever_m once a test lift was made: where the centre of gravity is believed "
      "then, hands may be beside it, and the probability of a level grip decides (m).");
    v.or_infinite("max_lever_m");
    v("belief", belief, "What is believed of an object before it is lifted.");
  }
};

}  // namespace colift::control
