#pragma once

#include "hal/config/range.hpp"
#include "hal/guards/guarded_arm.hpp"

namespace colift::control {

/// Limits of what the arm's set points add of their own accord: stops, corrections, ramps; and when the arm
/// is blocked. Wider than those of a planned motion (planner::MotionLimits), tighter than those of the last
/// gate (hal::GuardConfig).
struct SetpointLimits {
  double velocity_fraction = 0.9;
  double gate_fraction = 0.9;
  double velocity_rad_s = 10.0;  ///< No joint is faster. Not a parameter: below() makes it.
  double acceleration_rad_s2 = 5.0;
  double jerk_rad_s3 = 200.0;
  double urgent_factor = 2.7;
  double resume_rad_s2 = 3.0;
  double resume_rad_s3 = 40.0;
  double limit_margin_rad = 0.02;
  double start_tolerance_rad = 0.03;
  double blend_s = 0.5;
  double stiffness_slope_nm_rad_s = 3000;
  double superposed_nm = 50;
  double torque_slope_nm_s = 150;
  double contact_filter_s = 0.004;
  double torque_error_nm = 0.25;
  double tool_error_kg = 0.3;
  double rest_filter_s = 0.1;
  double follow_error_rad = 0.06;
  double rearm_fraction = 0.8;
  double gap_s = 0.05;
  double slow_hold_s = 0.5;
  double slow_slope_1_s = 2.0;
  double stop_slope_1_s = 8.0;

  template <class Visitor>
  void visit(Visitor& v) {
    v("velocity_fraction", velocity_fraction, hal::Range{0.01, 1},
      "Fraction of the joints' own velocity limits that is used.");
    v("gate_fraction", gate_fraction, hal::Range{0.01, 1},
      "No set point is faster than this fraction of guard_arm.max_velocity_rad_s: the last gate never brakes "
      "it.");
    v("acceleration_rad_s2", acceleration_rad_s2, hal::Range{0.1, 100},
      "Acceleration of stops and of followed set points (rad/s^2).");
    v("jerk_rad_s3", jerk_rad_s3, hal::Range{1, 10000}, "Jerk of stops on the path (rad/s^3).");
    v("urgent_factor", urgent_factor, hal::Range{1, 3},
      "An arm that is pushed, or that nobody looks after any more, stops with this multiple of both; below "
      "guard_arm.acceleration_rad_s2.");
    v("resume_rad_s2", resume_rad_s2, hal::Range{0.1, 100},
      "Acceleration along the path after a stop or a slow stretch (rad/s^2).");
    v("resume_rad_s3", resume_rad_s3, hal::Range{1, 10000}, "Its jerk (rad/s^3).");
    v("limit_margin_rad", limit_margin_rad, hal::Range{0.001, 0.5}, "Kept from the joint limits (rad).");
    v("start_tolerance_rad", start_tolerance_rad, hal::Range{0.001, 0.2},
      "Max distance between a trajectory's start and the commanded position (rad).");
    v("blend_s", blend_s, hal::Range{0.01, 5}, "Time in which that distance is blended out (s).");
    v("stiffness_slope_nm_rad_s", stiffness_slope_nm_rad_s, hal::kPositive,
      "Max change of stiffness in a second (N m/rad/s).");
    v("superposed_nm", superposed_nm, hal::Range{0, 200},
      "Max torque that is added; never more than a joint bears (N m).");
    v("torque_slope_nm_s", torque_slope_nm_s, hal::kPositive,
      "Max change of the added torque in a second (N m/s).");
    v("contact_filter_s", contact_filter_s, hal::Range{0, 0.1}, "Time constant of the contact force (s).");
    v("torque_error_nm", torque_error_nm, hal::Range{0, 5},
      "Error of each joint's external torque (N m): near a stretched arm, where it alone would be felt as a "
      "large force, the contact force is rather felt too small.");
    v("tool_error_kg", tool_error_kg, hal::Range{0, 5},
      "The same of a tool whose mass is wrong by this (kg): it weighs on the joints in each posture "
      "otherwise.");
    v("rest_filter_s", rest_filter_s, hal::Range{0.001, 10},
      "Time constant of what is measured at rest, the zero of the contact force (s).");
    v("follow_error_rad", follow_error_rad, hal::Range{0.005, 0.5},
      "An arm that lags by more does not follow: it is blocked (rad).");
    v("rearm_fraction", rearm_fraction, hal::Range{0.1, 1},
      "Fraction of its limits below which contact detection is armed again after a contact.");
    v("gap_s", gap_s, hal::Range{0.005, 1}, "A longer time between two states starts from rest again (s).");
    v("slow_hold_s", slow_hold_s, hal::Range{0, 60},
      "The arm stays slow for this time after the controller's last warning (s).");
    v("slow_slope_1_s", slow_slope_1_s, hal::Range{0.1, 100},
      "How fast the speed scale of a lift rises (1/s) ...");
    v("stop_slope_1_s", stop_slope_1_s, hal::Range{0.1, 100},
      "... and falls: whoever comes near is to find the arm at rest (1/s).");
  }

  /// The same below the velocity limit of the last gate.
  [[nodiscard]] SetpointLimits below(const hal::GuardConfig& gate) const {
    SetpointLimits limits = *this;
    limits.velocity_rad_s = gate_fraction * gate.max_velocity_rad_s;
    return limits;
  }
};

}  // namespace colift::control
