#pragma once

#include <string>

#include "control/config/cartesian_config.hpp"
#include "control/config/let_go_config.hpp"
#include "control/config/tilt_compliance_config.hpp"
#include "hal/config/range.hpp"

namespace colift::control {

/// When a device counts as lost, and when the arm goes slowly. SI units.
struct SupervisionConfig {
  int arm_max_misses = 5;
  int arm_max_misses_at_start = 20;
  int arm_max_misses_at_activation = 50;
  double hand_timeout_s = 0.2;
  double camera_timeout_s = 0.3;
  double camera_reopen_s = 2.0;
  double slow_image_age_s = 0.15;
  double full_speed_image_age_s = 0.10;
  double image_age_filter_s = 0.4;
  double beat_timeout_s = 0.1;
  double stall_timeout_s = 1.0;
  double stall_recovery_s = 0.5;
  int max_stalls = 5;

  template <class Visitor>
  void visit(Visitor& v) {
    v("arm_max_misses", arm_max_misses, hal::Range{1, 1000},
      "Max cycles in a row without a state of the arm that count as answered.");
    v("arm_max_misses_at_start", arm_max_misses_at_start, hal::Range{1, 10000},
      "The same before the arm was ever commanded.");
    v("arm_max_misses_at_activation", arm_max_misses_at_activation, hal::Range{1, 10000},
      "The same for the first state after the arm was activated.");
    v("hand_timeout_s", hand_timeout_s, hal::Range{0.01, 10}, "Timeout of the hand's answers (s).");
    v("camera_timeout_s", camera_timeout_s, hal::Range{0.05, 10},
      "Timeout of new frames, after which the camera is lost (s).");
    v("camera_reopen_s", camera_reopen_s, hal::Range{0.1, 60},
      "Time between two attempts to open an unplugged camera (s).");
    v("slow_image_age_s", slow_image_age_s, hal::Range{0.01, 10},
      "Mean age of the newest frame from which the arm goes slowly (s).");
    v("full_speed_image_age_s", full_speed_image_age_s, hal::Range{0.01, 10},
      "Mean age below which it goes at full speed again (s).");
    v("image_age_filter_s", image_age_filter_s, hal::Range{0.001, 10}, "Time constant of that mean (s).");
    v("beat_timeout_s", beat_timeout_s, hal::Range{0.02, 10},
      "A moving arm stops by itself when the job's thread has not run for this time; an arm whose thread has "
      "not run for it is lost (s).");
    v("stall_timeout_s", stall_timeout_s, hal::Range{0, 60},
      "A job whose thread did not run for longer than this while the arm moved ends (s).");
    v("stall_recovery_s", stall_recovery_s, hal::Range{0, 60},
      "After a shorter one the arm continues when the thread has run in time for this (s).");
    v("max_stalls", max_stalls, hal::Range{0, 1000}, "Max number of these in a job.");
  }
};

/// What is tried how often before the job is given up. SI units.
struct AttemptConfig {
  int max_planned_grasps = 8;
  int max_approaches = 5;
  int max_grips = 2;
  double failed_grip_radius_m = 0.06;
  double touched_radius_m = 0.15;
  double second_partner_timeout_s = 10.0;
  double object_moved_m = 0.004;
  double max_object_moved_m = 0.06;

  template <class Visitor>
  void visit(Visitor& v) {
    v("max_planned_grasps", max_planned_grasps, hal::Range{1, 200},
      "Max grasps of one decision for which a path is planned.");
    v("max_approaches", max_approaches, hal::Range{1, 100},
      "Max approaches of a job; each test lift allows one more.");
    v("max_grips", max_grips, hal::Range{1, 20},
      "Max approaches after which a failed grip is tried elsewhere; each test lift allows one more.");
    v("failed_grip_radius_m", failed_grip_radius_m, hal::Range{0, 1},
      "No grasp is tried so near to a grip that failed (m).");
    v("touched_radius_m", touched_radius_m, hal::Range{0, 1},
      "No grasp is tried from the same side so near to one on whose way the open hand met something (m).");
    v("second_partner_timeout_s", second_partner_timeout_s, hal::Range{0.1, 3600},
      "Timeout for a partner who has grasped before; never more than task.partner_timeout_s (s).");
    v("object_moved_m", object_moved_m, hal::Range{0, 0.1},
      "An object that was put down farther from where it stood is taken as moved (m).");
    v("max_object_moved_m", max_object_moved_m, hal::Range{0, 1},
      "One that moved farther has to be observed anew: the job ends (m).");
  }
};

/// Motion with an empty hand: approach, back-off, retreat. SI units.
struct EmptyHandConfig {
  double approach_timeout_factor = 2.0;
  double approach_timeout_margin_s = 5.0;
  double back_off_scale = 0.6;
  double return_timeout_s = 60.0;
  double touch_clear_m = 0.15;
  double max_touch_s = 1.0;

  template <class Visitor>
  void visit(Visitor& v) {
    v("approach_timeout_factor", approach_timeout_factor, hal::Range{1, 100},
      "Timeout of the approach, as a multiple of its planned time at task.slow_fraction of the speed.");
    v("approach_timeout_margin_s", approach_timeout_margin_s, hal::Range{0, 600}, "Added to that (s).");
    v("back_off_scale", back_off_scale, hal::Range{0.05, 1},
      "Speed scale of the motion back along the approach.");
    v("return_timeout_s", return_timeout_s, hal::Range{1, 3600}, "Timeout of back-off and of retreat (s).");
    v("touch_clear_m", touch_clear_m, hal::Range{0, 5},
      "With everybody farther from the arm than that, what an open hand meets beside the object is the "
      "object, and the hand goes back (m).");
    v("max_touch_s", max_touch_s, hal::Range{0, 10},
      "Max time for which the force of such a contact lasts; 0: each contact ends the job (s).");
  }
};

/// Closing, checking and opening the hand. SI units.
struct GripConfig {
  double hand_timeout_s = 8.0;
  double command_shows_s = 0.2;
  double finger_tolerance_rad = 0.45;
  double max_excess_width_m = 0.012;
  double ready_timeout_s = 20.0;
  double open_tolerance_rad = 0.1;
  double min_held_fraction = 0.4;
  double min_friction_margin = 1.0;
  double min_usual_margin = 0.7;
  double ease_s = 0.08;
  double friction = 0.5;
  double contact_n = 0.3;
  double cell_contact_n_cm2 = 0.1;

  template <class Visitor>
  void visit(Visitor& v) {
    v("hand_timeout_s", hand_timeout_s, hal::Range{0.5, 60},
      "Timeout of closing and of opening: initialisation and full strokes take under 4 s (s).");
    v("command_shows_s", command_shows_s, hal::Range{0, 5},
      "Time after which the hand's state shows a command that was given (s).");
    v("finger_tolerance_rad", finger_tolerance_rad, hal::Range{0.01, 3},
      "Max difference of a finger from the angle that the observed width predicts (rad).");
    v("max_excess_width_m", max_excess_width_m, hal::Range{0.001, 0.2},
      "Something is between fingers and object when they stop this much wider apart than it was seen to be "
      "(m).");
    v("ready_timeout_s", ready_timeout_s, hal::Range{0.1, 3600},
      "Timeout for the partner to hold still once the hand is closed (s).");
    v("open_tolerance_rad", open_tolerance_rad, hal::Range{0.01, 2},
      "A finger below this angle is open (rad).");
    v("min_held_fraction", min_held_fraction, hal::kFraction,
      "The object is not lifted when the strongest finger's strain gauge measures less than this fraction of "
      "the torque that was asked.");
    v("min_friction_margin", min_friction_margin, hal::Range{0, 10},
      "The object is not lifted when its expected load may grow by less than this factor until the pads, as "
      "they measure, let it slip; 0: lifted all the same.");
    v("min_usual_margin", min_usual_margin, hal::Range{0, 10},
      "The same where the mass is not known and decision.usual_mass_kg stands for it: a guess refuses only "
      "what is far too weak, and slip is watched for in the lift.");
    v("ease_s", ease_s, hal::Range{0, 10},
      "While the grip is verified, the palm's set point goes to where the palm stands once in this time: "
      "closing fingers have shifted the object against springs and partner; 0: never (s).");
    v("friction", friction, hal::Range{0.05, 2},
      "Friction of pads on the object, for the load that a grip carries.");
    v("contact_n", contact_n, hal::Range{0.01, 20}, "Force on a tactile pad that is a contact (N).");
    v("cell_contact_n_cm2", cell_contact_n_cm2, hal::Range{0.01, 15},
      "Pressure on a cell of a tactile pad that is a contact (N/cm2).");
  }
};

/// The palm's motion while the object is lifted. SI units.
struct LiftMotionConfig {
  double feed_forward_filter_s = 0.25;
  double follow_speed_m_s = 0.08;
  double follow_gain_1_s = 4.0;
  double follow_acceleration_m_s2 = 0.4;
  double tested_speed_m_s = 0.005;
  double leader_rise_m = 0.008;
  std::string control = "joint_impedance";
  CartesianConfig cartesian;
  TiltComplianceConfig tilt_compliance;
  double energy_margin_j = 3.0;
  double energy_band_j = 0.5;

  template <class Visitor>
  void visit(Visitor& v) {
    v("feed_forward_filter_s", feed_forward_filter_s, hal::Range{0, 10},
      "Time constant of the load that is fed forward: slower than the object swings, faster than a lift "
      "(s).");
    v("follow_speed_m_s", follow_speed_m_s, hal::Range{0.001, 0.5},
      "Max speed of the palm that follows; a person who lifts 5 cm in 2 s peaks at 0.047 m/s (m/s).");
    v("follow_gain_1_s", follow_gain_1_s, hal::Range{0.1, 50},
      "Speed of the following palm per height that it is behind (1/s).");
    v("follow_acceleration_m_s2", follow_acceleration_m_s2, hal::Range{0.01, 10},
      "Max acceleration of the following palm (m/s^2).");
    v("tested_speed_m_s", tested_speed_m_s, hal::Range{0.001, 0.1},
      "Max mean speed of the lift after a test lift (m/s).");
    v("leader_rise_m", leader_rise_m, hal::Range{0.001, 0.1},
      "The partner leads when his end is higher than the palm by this (m).");
    v("control", control, hal::Choices{"joint_impedance", "cartesian_impedance"},
      "Impedance of the arm while it carries: of its joints, or of the palm (stiff along gravity and in "
      "tilt, soft sideways).");
    v("cartesian", cartesian, "The palm's impedance.");
    v("tilt_compliance", tilt_compliance, "How the palm gives way to what tilts the object.");
    v("energy_margin_j", energy_margin_j, hal::Range{0, 100},
      "Energy that the arm may put into object and people beside what lifts max_load_n by lift_height_m; who "
      "has put in all of it lowers the object (J).");
    v("energy_band_j", energy_band_j, hal::Range{0, 10},
      "Over the last of it the palm rises ever more slowly (J).");
  }
};

/// Limits and signs while the object is carried; beside max_tilt_deg, max_slip_m and max_load_n. SI units.
struct CarryConfig {
  int limit_frames = 3;
  double settle_s = 0.3;
  double steady_load_n = 0.5;
  double steady_load_fraction = 0.03;
  double steady_s = 0.6;
  double max_unsteady_s = 5.0;
  double partner_fall_m = 0.02;
  double load_jump_factor = 1.4;
  double load_jump_n = 6.0;
  double ground_tolerance_m = 0.002;
  double ground_load_n = 0.5;
  double standing_tolerance_m = 0.01;
  double max_askew_deg = 6.0;
  double standing_load_n = 3.0;
  double standing_load_fraction = 0.1;
  double seek_m = 0.02;
  double seek_speed_m_s = 0.005;
  double max_release_force_n = 60.0;
  double partner_lag_m = 0.035;
  double load_gain_n = 25.0;
  double pull_n = 30.0;
  double load_loss_fraction = 0.3;
  double load_loss_s = 0.15;
  double regrasp_s = 0.5;
  double regrasp_timeout_s = 20.0;
  int max_regrasps = 5;
  double regrasp_load_factor = 0.3;

  template <class Visitor>
  void visit(Visitor& v) {
    v("limit_frames", limit_frames, hal::Range{1, 100},
      "Frames in a row beyond a limit of tilt or slip that end a lift.");
    v("settle_s", settle_s, hal::Range{0, 10}, "Time at rest before the end of a motion is believed (s).");
    v("steady_load_n", steady_load_n, hal::Range{0.01, 50},
      "The hold begins when the load on the hand changes by no more than this in 0.4 s (N) ...");
    v("steady_load_fraction", steady_load_fraction, hal::kFraction,
      "... or than this fraction of itself, ...");
    v("steady_s", steady_s, hal::Range{0, 10}, "... for this time (s) ...");
    v("max_unsteady_s", max_unsteady_s, hal::Range{0, 60},
      "... or at the latest this long after the palm has come to rest at the top (s).");
    v("partner_fall_m", partner_fall_m, hal::Range{0.002, 0.5},
      "The partner has let go when his end comes down by this during the hold (m).");
    v("load_jump_factor", load_jump_factor, hal::Range{1, 10},
      "He has let go, too, when the load grows by this factor over its mean ...");
    v("load_jump_n", load_jump_n, hal::Range{0, 100}, "... and by at least this (N).");
    v("ground_tolerance_m", ground_tolerance_m, hal::Range{0, 0.05},
      "The object is on the ground when its grip is this near to where it was (m) ...");
    v("ground_load_n", ground_load_n, hal::Range{0, 50}, "... and the robot's load is not above this (N).");
    v("standing_tolerance_m", standing_tolerance_m, hal::Range{0, 0.05},
      "The object stands when both of its ends are seen this near to where they stood (m) ...");
    v("max_askew_deg", max_askew_deg, hal::Range{0, 30},
      "Max tilt of an object that is let go on an edge, to settle on its feet: where the hand feels the "
      "ground and its lowest corner is seen where it stood (deg).");
    v("standing_load_n", standing_load_n, hal::Range{0, 50},
      "... and the hand carries less than this (N) ...");
    v("standing_load_fraction", standing_load_fraction, hal::kFraction,
      "... or less than this fraction of its load in the air.");
    v("seek_m", seek_m, hal::Range{0, 0.1},
      "A palm that still carries is lowered by this at most, below where it grasped (m) ...");
    v("seek_speed_m_s", seek_speed_m_s, hal::Range{0.0005, 0.05}, "... with this mean speed (m/s).");
    v("max_release_force_n", max_release_force_n, hal::Range{1, 200},
      "The hand opens below this horizontal force only (N).");
    v("partner_lag_m", partner_lag_m, hal::Range{0.005, 0.2},
      "The partner does not lift, or has let go, when his end is lower than the palm by this and more than "
      "it was (m).");
    v("pull_n", pull_n, hal::Range{1, 500},
      "Change of the sideways force on the hand against its mean (let_go.pull_filter_s) that is a pull (N).");
    v("load_gain_n", load_gain_n, hal::Range{1, 200},
      "He has let go, too, when the load grows by this over its mean (let_go.load_filter_s) (N).");
    v("load_loss_fraction", load_loss_fraction, hal::kFraction,
      "The object is lost when the load in the air falls below this fraction of its mean ...");
    v("load_loss_s", load_loss_s, hal::Range{0, 5}, "... for this time (s).");
    v("regrasp_s", regrasp_s, hal::Range{0, 10},
      "How long a partner who let go has to hold again before the arm continues (s).");
    v("regrasp_timeout_s", regrasp_timeout_s, hal::Range{0.1, 3600},
      "Timeout for him to grasp again; then the arm holds, and a person decides (s).");
    v("max_regrasps", max_regrasps, hal::Range{0, 1000},
      "Max number of times that he lets go or pulls and the lift continues all the same; then the object is "
      "set down together.");
    v("regrasp_load_factor", regrasp_load_factor, hal::kFraction,
      "Max deviation of the load from what it was, as a fraction, at which he is taken to carry again.");
  }
};

/// The job as a whole. SI units.
struct TaskConfig {
  int reference_frames = 15;
  double partner_timeout_s = 30.0;
  double hidden_hand_s = 3.0;
  int asks = 2;
  double ready_s = 0.5;
  double intent_lead_s = 0.5;
  double lift_height_m = 0.05;
  double lift_s = 2.0;
  double hold_s = 2.0;
  double close_torque_nm = 1.0;
  double stiffness_nm_rad = 1500.0;
  double max_tilt_deg = 5.0;
  double max_slip_m = 0.02;
  double max_load_n = 60.0;
  double contact_n = 30.0;
  double slow_fraction = 0.3;
  double arm_timeout_s = 1.0;
  double limit_margin_deg = 1.2;
  AttemptConfig attempts;
  SupervisionConfig supervision;
  EmptyHandConfig empty_hand;
  GripConfig grip;
  LiftMotionConfig lift;
  CarryConfig carry;
  LetGoConfig let_go;
  EvidenceConfig evidence;

  template <class Visitor>
  void visit(Visitor& v) {
    v("reference_frames", reference_frames, hal::Range{1, 60},
      "Frames that the picture of the scene is made of.");
    v("partner_timeout_s", partner_timeout_s, hal::Range{0.1, 3600},
      "Timeout for the partner's grasp, and for a lost camera (s).");
    v.renamed("patience_s", "partner_timeout_s");
    v("hidden_hand_s", hidden_hand_s, hal::Range{0, 3600},
      "Time after which somebody whose body hides the object's edge is asked to step aside (s).");
    v("asks", asks, hal::Range{0, 20},
      "Max number of requests to the partner to grasp elsewhere when the robot has no feasible grasp.");
    v("ready_s", ready_s, hal::Range{0, 10}, "How long the partner has to hold still before the lift (s).");
    v("intent_lead_s", intent_lead_s, hal::Range{0, 5},
      "Time from the announcement of a motion to its begin (s); 0: motions are not announced.");
    v("lift_height_m", lift_height_m, hal::Range{0.005, 0.5}, "Height of the lift (m).");
    v("lift_s", lift_s, hal::Range{0.2, 30}, "Time of the lift (s).");
    v("hold_s", hold_s, hal::Range{0, 600}, "How long the object is held up (s).");
    v("close_torque_nm", close_torque_nm, hal::Range{0.05, 2},
      "Torque with which fingers close (N m at the tips).");
    v("stiffness_nm_rad", stiffness_nm_rad, hal::Range{50, 2000}, "Joint stiffness of the arm (N m/rad).");
    v("max_tilt_deg", max_tilt_deg, hal::Range{0.5, 45},
      "Max tilt of the object; beyond it the lift ends (deg).");
    v("max_slip_m", max_slip_m, hal::Range{0.002, 0.2}, "Max slip in the hand; beyond it the lift ends (m).");
    v("max_load_n", max_load_n, hal::Range{1, 70},
      "Max load of the arm (N); its rated payload is 7 kg with the hand.");
    v("contact_n", contact_n, hal::Range{1, 200},
      "Force threshold of an unexpected contact during free motion (N).");
    v("slow_fraction", slow_fraction, hal::Range{0.05, 1}, "Speed scale while the arm's controller warns.");
    v.renamed("slow_part", "slow_fraction");
    v("arm_timeout_s", arm_timeout_s, hal::Range{0, 30},
      "Timeout while the arm's controller accepts no commands; after it the job ends (s).");
    v.renamed("arm_patience_s", "arm_timeout_s");
    v("limit_margin_deg", limit_margin_deg, hal::Range{1.2, 45},
      "Margin to the joint limits while the object is carried; plans keep motion.limit_margin_deg (deg).");
    v("attempts", attempts, "What is tried how often before the job is given up.");
    v("supervision", supervision, "When a device counts as lost, and when the arm goes slowly.");
    v("empty_hand", empty_hand, "Motion with an empty hand: approach, back-off, retreat.");
    v("grip", grip, "Closing, checking and opening the hand.");
    v("lift", lift, "The palm's motion while the object is lifted.");
    v("carry", carry, "Limits and signs while the object is carried.");
    v("let_go", let_go, "How quickly it is noticed that the partner let go.");
    v("evidence", evidence, "What has to be seen and felt before a lift is called one.");
  }
};

}  // namespace colift::control
