#pragma once

#include "hal/config/range.hpp"

namespace colift::control {

/// Force and torque at the palm that nobody expects in a state: against what was felt before the hand
/// touched anything, by direction. SI units.
struct ForceLimits {
  double sideways_n, up_n, down_n, torque_nm;

  template <class Visitor>
  void visit(Visitor& v) {
    v("sideways_n", sideways_n, hal::Range{5, 200}, "Max horizontal force on the hand (N).");
    v("up_n", up_n, hal::Range{5, 200}, "Max force that pushes the hand up (N).");
    v("down_n", down_n, hal::Range{5, 200}, "Max force that pulls the hand down (N).");
    v("torque_nm", torque_nm, hal::Range{1, 100}, "Max torque about the palm (N m).");
  }
};

/// Unexpected force in every state, and what the arm does about it. Limits lie above what nominal lifts of
/// table, box, pipe and chair show (horizontal 33 N, up 12 N, down 48 N, torque 7 N m; while fingers close on
/// an edge sideways 46 N, up 42 N) and below the 110 N
/// that ISO/TS 15066 permits in a clamped trunk and the 140 N of a hand. SI units.
struct ForceMonitorConfig {
  bool on = true;
  double filter_s = 0.004;
  double rest_filter_s = 0.5;
  double rest_n = 30.0;
  double joint_nm = 60.0;
  ForceLimits closing{60.0, 60.0, 45.0, 15.0};
  ForceLimits carried{60.0, 60.0, 100.0, 25.0};
  ForceLimits lowering{60.0, 25.0, 100.0, 25.0};
  double yield_stiffness_nm_rad = 150.0;
  double yield_slope_nm_rad_s = 50000.0;
  double yield_band_rad = 0.1;
  double yield_relaxed_band_rad = 0.03;
  double yield_relax_s = 0.3;
  double yield_rest_filter_s = 0.2;
  double yield_max_held_nm = 10.0;
  double yield_still_rad_s = 0.1;
  double yield_swing_s = 0.5;
  double settle_s = 0.5;
  double rearm_fraction = 0.8;
  double yield_s = 3.0;
  double max_yield_s = 30.0;

  template <class Visitor>
  void visit(Visitor& v) {
    v("on", on, "Whether the arm stops on unexpected force while the hand is at the object or at rest.");
    v("filter_s", filter_s, hal::Range{0, 0.1}, "Time constant of the force that is compared (s).");
    v("rest_filter_s", rest_filter_s, hal::Range{0.05, 10},
      "Time constant of what an arm at rest with an empty hand takes as its zero (s).");
    v("rest_n", rest_n, hal::Range{5, 200}, "Max force on an arm at rest with an empty hand (N).");
    v("joint_nm", joint_nm, hal::Range{1, 300},
      "Max external torque of any joint while the hand is at the object (N m).");
    v("closing", closing, "While the hand closes and until the lift begins.");
    v("carried", carried, "While the object is raised and held.");
    v("lowering", lowering, "While it is lowered: something may be under it.");
    v("yield_stiffness_nm_rad", yield_stiffness_nm_rad, hal::Range{10, 2000},
      "Joint stiffness of an arm that yields to a person, its load compensated (N m/rad).");
    v("yield_band_rad", yield_band_rad, hal::Range{0.005, 1},
      "An arm that is pushed farther than this follows, and does not spring back (rad).");
    v("yield_slope_nm_rad_s", yield_slope_nm_rad_s, hal::Range{100, 1000000},
      "How fast the joints become so soft (N m/rad/s).");
    v("yield_relaxed_band_rad", yield_relaxed_band_rad, hal::Range{0.005, 1},
      "Where the set point creeps to while more than a limit is felt: who stays pressed is pressed with no "
      "more (rad).");
    v("yield_relax_s", yield_relax_s, hal::Range{0, 10}, "Time constant of that (s).");
    v("yield_rest_filter_s", yield_rest_filter_s, hal::Range{0.01, 10},
      "Time constant of what the springs hold at rest, superposed before they become soft (s).");
    v("yield_max_held_nm", yield_max_held_nm, hal::Range{0, 100},
      "Max of that in a joint: more is no error of a load's estimate (N m).");
    v("yield_still_rad_s", yield_still_rad_s, hal::Range{0, 5},
      "A joint that swings out more slowly is not followed (rad/s).");
    v("yield_swing_s", yield_swing_s, hal::Range{0, 10},
      "Nor one that swings out for longer after the last push: what still moves it is no push (s).");
    v("settle_s", settle_s, hal::Range{0, 10},
      "Time after an own motion until an arm at rest takes what it feels as its zero (s).");
    v("rearm_fraction", rearm_fraction, hal::kFraction,
      "A limit that was exceeded counts again once less than this fraction of it is felt.");
    v("yield_s", yield_s, hal::Range{0, 600}, "How long it yields after the force is gone (s).");
    v("max_yield_s", max_yield_s, hal::Range{0.5, 3600}, "How long it yields at most (s).");
  }
};

/// Speed and separation monitoring: how fast the arm may be with people around. SI units. The distance to be
/// kept is ISO/TS 15066 5.5.4's; figures and their sources: docs/task.md.
struct MonitorConfig {
  bool on = true;
  double person_speed_m_s = 1.6;
  double deceleration_m_s2 = 1.0;
  double latency_s = 0.15;
  double intrusion_m = 0.10;
  double person_uncertainty_m = 0.05;
  double robot_uncertainty_m = 0.005;
  double arm_mass_kg = 16.0;
  double carried_mass_kg = 6.0;
  double hold_distance_m = 0.70;
  double hysteresis_m = 0.01;
  double observed_m = 1.5;
  double partner_speed_m_s = 0.3;
  double partner_hold_distance_m = 0.20;
  double partner_radius_m = 1.0;
  double forearm_m = 0.45;
  double hand_radius_m = 0.25;
  double hidden_hand_m = 0.60;
  double gap_m = 0.30;
  double inward_m = 0.10;
  double min_scale_change = 0.02;
  double thing_hold_distance_m = 0.10;
  double still_s = 5.0;
  double low_m = 1.1;
  bool resume = true;
  double free_s = 2.0;
  double free_to_start_s = 0.3;
  double max_wait_s = 60.0;
  double obstacle_wait_s = 4.0;
  double person_wait_s = 15.0;
  double hold_image_age_s = 0.30;
  int good_frames = 30;
  ForceMonitorConfig force;

  template <class Visitor>
  void visit(Visitor& v) {
    v("on", on, "Whether the arm slows and stops for people; off: it goes at T1's speed, and says so.");
    v("person_speed_m_s", person_speed_m_s, hal::Range{0.1, 5},
      "Speed of a person towards the robot (m/s; ISO 13855 has 1.6).");
    v("deceleration_m_s2", deceleration_m_s2, hal::Range{0.05, 20}, "Deceleration of a stop (m/s^2).");
    v("latency_s", latency_s, hal::Range{0, 2},
      "Min time from exposure to the begin of a stop; the measured one counts where it is longer (s).");
    v("intrusion_m", intrusion_m, hal::Range{0, 1}, "Reach of a body part that is not seen (m).");
    v("person_uncertainty_m", person_uncertainty_m, hal::Range{0, 1},
      "Uncertainty of a person's position (m).");
    v("robot_uncertainty_m", robot_uncertainty_m, hal::Range{0, 1},
      "Uncertainty of the robot's position (m).");
    v("arm_mass_kg", arm_mass_kg, hal::Range{0, 200},
      "Mass of the arm's moving parts, half of which counts in a contact (kg; LWR 4+: 16, its data sheet).");
    v("carried_mass_kg", carried_mass_kg, hal::Range{0, 100},
      "Mass of hand and share of the object in a contact (kg).");
    v("hold_distance_m", hold_distance_m, hal::Range{0, 5},
      "A person nearer to the arm or to the rest of its path stops it (m).");
    v("hysteresis_m", hysteresis_m, hal::Range{0, 1}, "Farther than that by this is free again (m).");
    v("observed_m", observed_m, hal::Range{0.5, 10}, "Farther bodies do not change the arm's speed (m).");
    v("partner_speed_m_s", partner_speed_m_s, hal::Range{0, 5},
      "Min speed that is assumed of the partner who holds the object; faster is measured (m/s).");
    v("partner_hold_distance_m", partner_hold_distance_m, hal::Range{0, 5},
      "The same for the body of the partner who holds the object (m).");
    v("partner_radius_m", partner_radius_m, hal::Range{0.2, 3},
      "Parts of the partner are at most this far from his grasp, on the floor plan (m).");
    v("forearm_m", forearm_m, hal::Range{0, 1},
      "His hand and forearm: this far from his grasp, on his side of it; limited by force, not by distance "
      "(m).");
    v("hand_radius_m", hand_radius_m, hal::Range{0.05, 1},
      "What is so near to his grasp belongs to him (m).");
    v("hidden_hand_m", hidden_hand_m, hal::Range{0.05, 2},
      "Distance from a hand that is hidden to what is seen of him (m).");
    v("gap_m", gap_m, hal::Range{0, 2}, "Max gap between parts of him that are seen apart (m).");
    v("inward_m", inward_m, hal::Range{0, 1},
      "His hand reaches so far from his grasp towards the robot (m).");
    v("min_scale_change", min_scale_change, hal::Range{0, 0.5},
      "Smaller changes of the arm's speed scale are not requested.");
    v("thing_hold_distance_m", thing_hold_distance_m, hal::Range{0, 5},
      "The same for something low that has been at rest (m).");
    v("still_s", still_s, hal::Range{0.5, 60},
      "Something low is a thing when it has been at rest so long (s).");
    v("low_m", low_m, hal::Range{0, 3}, "Height below which something is low (m).");
    v("resume", resume,
      "Whether the arm continues by itself after a stop, when nobody was touched; off: an operator confirms "
      "it.");
    v("free_s", free_s, hal::Range{0, 60}, "Time for which nobody may be near before it does (s).");
    v("free_to_start_s", free_to_start_s, hal::Range{0, 60},
      "The same where somebody was near before the arm moved: its start waits, and nothing was stopped (s).");
    v("max_wait_s", max_wait_s, hal::Range{1, 3600},
      "Max time of waiting at a stretch, for a person or for a confirmation; after it the job ends (s).");
    v("obstacle_wait_s", obstacle_wait_s, hal::Range{0.5, 600},
      "Time of waiting for a thing in the path before another path is planned (s).");
    v("person_wait_s", person_wait_s, hal::Range{0.5, 600}, "The same for a person (s).");
    v("hold_image_age_s", hold_image_age_s, hal::Range{0.05, 10},
      "Mean age of the newest frame from which the arm stops (s).");
    v("good_frames", good_frames, hal::Range{1, 1000},
      "Timely frames in a row after which a lost camera counts as back.");
    v("force", force, "Unexpected force on the arm, in every state.");
  }
};

}  // namespace colift::control
