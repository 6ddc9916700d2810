#pragma once

#include "hal/config/range.hpp"

namespace colift::control {

/// Speed and separation monitoring: how fast the arm may be with people around. SI units. The distance to be
/// kept is ISO/TS 15066 5.5.4's (control/monitor/separation.hpp), a person's speed ISO 13855's.
struct MonitorConfig {
  bool on = true;
  double person_speed_m_s = 1.6;
  double deceleration_m_s2 = 1.0;
  double latency_s = 0.15;
  double intrusion_m = 0.10;
  double person_uncertainty_m = 0.05;
  double robot_uncertainty_m = 0.005;
  double hold_distance_m = 0.70;
  double hysteresis_m = 0.05;
  double observed_m = 1.5;
  double partner_speed_m_s = 0.3;
  double partner_hold_distance_m = 0.20;
  double partner_radius_m = 1.0;
  double forearm_m = 0.45;
  double thing_hold_distance_m = 0.10;
  double still_s = 5.0;
  double low_m = 1.1;
  bool resume = true;
  double free_s = 2.0;
  double max_wait_s = 60.0;
  double obstacle_wait_s = 4.0;
  double person_wait_s = 15.0;
  double hold_image_age_s = 0.30;
  int good_frames = 30;

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
    v("hold_distance_m", hold_distance_m, hal::Range{0, 5},
      "A person nearer to the arm or to the rest of its path stops it (m).");
    v("hysteresis_m", hysteresis_m, hal::Range{0, 1}, "Farther than that by this is free again (m).");
    v("observed_m", observed_m, hal::Range{0.5, 10}, "Farther bodies do not change the arm's speed (m).");
    v("partner_speed_m_s", partner_speed_m_s, hal::Range{0, 5},
      "Min speed that is assumed of the partner who holds the object; faster is measured (m/s).");
    v("partner_hold_distance_m", partner_hold_distance_m, hal::Range{0, 5},
      "hold_distance_m for the body of the partner who holds the object (m).");
    v("partner_radius_m", partner_radius_m, hal::Range{0.2, 3},
      "Parts of the partner are at most this far from his grasp, on the floor plan (m).");
    v("forearm_m", forearm_m, hal::Range{0, 1},
      "His hand and forearm: this far from his grasp, on his side of it; limited by force, not by distance "
      "(m).");
    v("thing_hold_distance_m", thing_hold_distance_m, hal::Range{0, 5},
      "hold_distance_m for something low that has been at rest (m).");
    v("still_s", still_s, hal::Range{0.5, 60},
      "Something low is a thing when it has been at rest so long (s).");
    v("low_m", low_m, hal::Range{0, 3}, "Height below which something is low (m).");
    v("resume", resume, "Whether the arm continues by itself after a stop, when nobody was touched.");
    v("free_s", free_s, hal::Range{0, 60}, "Time for which nobody may be near before it does (s).");
    v("max_wait_s", max_wait_s, hal::Range{1, 3600},
      "Max time of waiting at a stretch; after it the job ends (s).");
    v("obstacle_wait_s", obstacle_wait_s, hal::Range{0.5, 600},
      "Time of waiting for a thing in the path before another path is planned (s).");
    v("person_wait_s", person_wait_s, hal::Range{0.5, 600}, "The same for a person (s).");
    v("hold_image_age_s", hold_image_age_s, hal::Range{0.05, 10},
      "Mean age of the newest frame from which the arm stops (s).");
    v("good_frames", good_frames, hal::Range{1, 1000},
      "Timely frames in a row after which a lost camera counts as back.");
  }
};

}  // namespace colift::control
