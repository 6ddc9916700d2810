#pragma once

namespace colift::tools {

/// What was true at one moment of a simulated run. Forces on the object, up positive.
struct TruthSample {
  double t_s = 0.0;  ///< Since the start of the run, as all times of a record.
  double robot_force_z_n = 0.0;
  double partner_force_z_n = 0.0;
  double floor_force_z_n = 0.0;
  double tilt_rad = 0.0;
  double height_m = 0.0;
  double slip_m = 0.0;
};

}  // namespace colift::tools
