#pragma once

#include "sim_hal/emulator/krc/plant/krc_plant.hpp"

namespace colift::sim_hal {

/// What the KRC lets a client do. Positions, velocities and accelerations are the controller's own (machine
/// data as a public client quotes them); tolerances and the Cartesian row are not published and are this
/// emulator's choice.
struct KrcLimits {
  hal::JointVector position_rad, velocity_rad_s, acceleration_rad_s2;
  hal::JointVector torque_nm;  ///< Spring and superposed torque together.
  double speed_m_s = 2.0, turning_rad_s = 3.5;

  double stiffness_nm_rad = 2000.0, damping = 1.0;
  double cart_stiffness_n_m = 5000.0, cart_stiffness_nm_rad = 300.0;
  double force_n = 300.0, moment_nm = 30.0;  ///< Spring and superposed wrench together.

  // on the way into command mode
  double entry_pose_rad = 0.002, entry_position_m = 0.002, entry_turn_rad = 0.01;
  double entry_torque_nm = 1.0, entry_force_n = 1.0, entry_moment_nm = 1.0;

  KrcLimits();
};

}  // namespace colift::sim_hal
