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
/// table, box, pipe and chair show (horizontal 33 N, up 12 N, down 48 N, torque 7 N m) and below the 110 N
/// that ISO/TS 15066 permits in a clamped trunk and the 140 N of a hand. SI units.
struct ForceMonitorConfig {
  bool on = true;
  double filter_s = 0.004;
  double rest_filter_s = 0.5;
  double rest_n = 30.0;
  double joint_nm = 60.0;
  ForceLimits closing{45.0, 40.0, 45.0, 15.0};
  ForceLimits carried{60.0, 35.0, 100.0, 25.0};
  ForceLimits lowering{60.0, 25.0, 100.0, 25.0};
  double yield_stiffness_nm_rad = 150.0;
  double yield_band_rad = 0.1;
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
    v("yield_s", yield_s, hal::Range{0, 600}, "How long it yields after the force is gone (s).");
    v("max_yield_s", max_yield_s, hal::Range{0.5, 3600}, "How long it yields at most (s).");
  }
};

/// What watches body, force and threads in every state.
struct MonitorConfig {
  ForceMonitorConfig force;

  template <class Visitor>
  void visit(Visitor& v) {
    v("force", force, "Unexpected force on the arm, in every state.");
  }
};

}  // namespace colift::control
