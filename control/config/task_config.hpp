#pragma once

#include "hal/config/range.hpp"

namespace colift::control {

/// The job as a whole. SI units.
struct TaskConfig {
  int reference_frames = 15;
  double patience_s = 30.0;
  int asks = 2;
  double ready_s = 0.5;
  double lift_height_m = 0.05;
  double lift_s = 2.0;
  double hold_s = 2.0;
  double close_torque_nm = 1.0;
  double stiffness_nm_rad = 1500.0;
  double max_tilt_deg = 5.0;
  double max_slip_m = 0.02;
  double max_load_n = 60.0;
  double contact_n = 30.0;
  double slow_part = 0.3;
  double arm_patience_s = 1.0;
  double limit_margin_deg = 1.2;

  template <class Visitor>
  void visit(Visitor& v) {
    v("reference_frames", reference_frames, hal::Range{1, 60},
      "Frames that the picture of the scene is made of.");
    v("patience_s", patience_s, hal::Range{0.1, 3600}, "How long a partner is waited for (s).");
    v("asks", asks, hal::Range{0, 20},
      "How often the partner is asked to take hold elsewhere where the robot has no grasp as he stands.");
    v("ready_s", ready_s, hal::Range{0, 10}, "How long the partner has to hold still before the lift (s).");
    v("lift_height_m", lift_height_m, hal::Range{0.005, 0.5}, "Height of the lift (m).");
    v("lift_s", lift_s, hal::Range{0.2, 30}, "Time of the lift (s).");
    v("hold_s", hold_s, hal::Range{0, 600}, "How long the object is held up (s).");
    v("close_torque_nm", close_torque_nm, hal::Range{0.05, 2},
      "Torque with which fingers close (N m at the tips).");
    v("stiffness_nm_rad", stiffness_nm_rad, hal::Range{50, 2000}, "Joint stiffness of the arm (N m/rad).");
    v("max_tilt_deg", max_tilt_deg, hal::Range{0.5, 45}, "A lift that tilts the object further ends (deg).");
    v("max_slip_m", max_slip_m, hal::Range{0.002, 0.2}, "A grip that slips further ends the lift (m).");
    v("max_load_n", max_load_n, hal::Range{1, 70},
      "Greatest load of the arm (N); it bears 7 kg with its hand.");
    v("contact_n", contact_n, hal::Range{1, 200},
      "Force that counts as an unexpected contact on the way (N).");
    v("slow_part", slow_part, hal::Range{0.05, 1},
      "Part of its speed that the arm goes on with while its controller warns.");
    v("arm_patience_s", arm_patience_s, hal::Range{0, 30},
      "How long the arm may stand because its controller takes no commands, before the job ends (s).");
    v("limit_margin_deg", limit_margin_deg, hal::Range{1.2, 45},
      "Kept from the joints' limits while the object is borne; plans keep motion.limit_margin_deg (deg).");
  }
};

}  // namespace colift::control
