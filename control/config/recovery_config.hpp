#pragma once

#include "hal/config/range.hpp"

namespace colift::control {

/// `colift recover`: lowering, release and the motion home after a stop. SI units.
struct RecoveryConfig {
  double assess_s = 0.4;
  double assess_timeout_s = 3.0;
  double still_rad = 0.005;
  double home_rad = 0.02;
  double scene_timeout_s = 3.0;
  double lower_speed_m_s = 0.02;
  double max_lower_m = 0.6;
  double supported_n = 3.0;
  double supported_fraction = 0.1;
  double supported_sideways_n = 8.0;
  double press_n = 15.0;
  double settle_s = 0.4;
  double take_over_s = 5.0;
  double clear_m = 0.12;
  int attempts = 3;
  double speed_scale = 0.3;
  double hold_to_run_s = 0.7;
  double open_tolerance_rad = 0.1;
  double step_timeout_s = 120.0;

  template <class Visitor>
  void visit(Visitor& v) {
    v("assess_s", assess_s, hal::Range{0.05, 60},
      "Time over which the arm's states are looked at before anything moves (s).");
    v("assess_timeout_s", assess_timeout_s, hal::Range{0.05, 600},
      "Timeout for these, of an arm whose controller does not send yet (s).");
    v("still_rad", still_rad, hal::Range{0, 0.1},
      "An arm whose joints move by more than this meanwhile is moving (rad).");
    v("home_rad", home_rad, hal::Range{0, 0.5}, "It is at home when every joint is this near (rad).");
    v("scene_timeout_s", scene_timeout_s, hal::Range{0, 60},
      "Timeout of the frames that the motion home is planned with (s).");
    v("lower_speed_m_s", lower_speed_m_s, hal::Range{0.001, 0.1},
      "Mean speed with which a held object is lowered (m/s).");
    v("max_lower_m", max_lower_m, hal::Range{0.01, 1.5},
      "The object is lowered by no more than this in search of the ground (m).");
    v("supported_n", supported_n, hal::Range{0.1, 50},
      "The object is supported when the load is below this (N) ...");
    v("supported_fraction", supported_fraction, hal::Range{0, 0.9},
      "... or below this fraction of the load before it was lowered.");
    v("supported_sideways_n", supported_sideways_n, hal::Range{0.5, 100},
      "... and it leans on the hand sideways with no more than this (N).");
    v("press_n", press_n, hal::Range{1, 60},
      "It is supported, too, when it is pressed on the ground with this force; lowering ends there (N).");
    v("settle_s", settle_s, hal::Range{0.05, 10}, "For so long, before it is believed (s).");
    v("take_over_s", take_over_s, hal::Range{0.5, 60},
      "A person who is said to hold the object gets so long until the load is his (s).");
    v("attempts", attempts, hal::Range{1, 10},
      "A step that met something, or fingers that did not open, are tried so often, each time on a "
      "confirmation that they were freed.");
    v("clear_m", clear_m, hal::Range{0, 0.5},
      "The open hand is drawn back straight by this before the motion home (m).");
    v("speed_scale", speed_scale, hal::Range{0.01, 1}, "Speed scale of the motion home.");
    v("hold_to_run_s", hold_to_run_s, hal::Range{0.1, 5},
      "The arm stops when the key was not repeated for this time (s).");
    v("open_tolerance_rad", open_tolerance_rad, hal::Range{0.01, 2},
      "A finger below this angle is open (rad).");
    v("step_timeout_s", step_timeout_s, hal::Range{1, 3600}, "Timeout of one step (s).");
  }
};

}  // namespace colift::control
