#pragma once

#include <string>

#include "hal/config/range.hpp"

namespace colift::hal {

/// How the KRC is reached and treated. Deadlines count the machine's time, ramps the packets' time.
struct FriConfig {
  std::string address = "0.0.0.0";
  int port = 49938;
  std::string krc;
  int cpu = -1;
  double cycle_ms = 2.0;
  std::string script = "colift";
  std::string control = "joint_impedance";
  std::string min_quality = "ok";
  bool check_header = true;
  bool check_sequence = true;
  std::string external_torque = "on_arm";
  double first_s = 5.0;
  double ready_s = 30.0;
  double script_s = 2.0;
  double stop_s = 10.0;
  double silent_s = 0.1;
  double velocity_fraction = 1.0;
  double acceleration_rad_s2 = 15.0;
  double max_superposed_nm = 60.0;
  double superposed_slope_nm_s = 200.0;
  double start_stiffness_nm_rad = 1000.0;
  double start_damping = 0.7;
  double start_cart_stiffness_n_m = 1000.0;
  double start_cart_stiffness_nm_rad = 100.0;
  double start_external_nm = 20.0;
  double cart_velocity_m_s = 0.5;
  double cart_velocity_rad_s = 1.5;
  bool null_space_posture = false;
  double warm_c = 70.0;
  double hot_c = 85.0;
  bool end_script = false;

  template <class Visitor>
  void visit(Visitor& v) {
    v("address", address, "IPv4 address of this machine on which the KRC's datagrams come; 0.0.0.0: any.");
    v("port", port, Range{0, 65535}, "UDP port that the KRC sends to (FRIHOST, FRISOCK or friSetup).");
    v("krc", krc,
      "IPv4 address of the KRC, with or without :port; empty: the first sender is read, but command mode is "
      "asked of it only if it is on this machine.");
    v("cpu", cpu, Range{-1, 1023},
      "CPU on which the KRC's datagrams are answered, best one kept free of other work; -1: any.");
    v("cycle_ms", cycle_ms, Range{1, 100}, "Period that is expected until the KRC reports its own (ms).");
    v("script", script, Choices{"colift", "stanford", "tum", "cep", "openkc", "vendor", "none"},
      "KRL program that runs on the KRC; none: a person starts command mode at the panel.");
    v("control", control, Choices{"joint_impedance", "position", "cartesian_impedance"},
      "Control strategy that is asked for and commanded.");
    v("min_quality", min_quality, Choices{"bad", "ok", "perfect"},
      "Quality of the connection that is needed to start.");
    v.renamed("least_quality", "min_quality");
    v("check_header", check_header, "Refuse datagrams with another id or size in their header.");
    v("check_sequence", check_sequence,
      "Refuse doubled and reordered datagrams by their counter; off for servers that do not count.");
    v("external_torque", external_torque, Choices{"on_arm", "on_environment"},
      "What the KRC's estimate of external torque and wrench means: acting on the arm, or by the arm.");
    v("first_s", first_s, kPositive, "Longest wait for the first datagram (s).");
    v("ready_s", ready_s, kPositive, "Longest wait for command mode (s).");
    v("script_s", script_s, kPositive, "Longest wait for an answer of the KRL program (s).");
    v("stop_s", stop_s, kPositive, "Longest wait for monitor mode at the end (s).");
    v("silent_s", silent_s, Range{0.01, 10}, "Without a datagram for so long the link counts as lost (s).");
    v("velocity_fraction", velocity_fraction, kFraction,
      "Velocity scale: fraction of the joints' velocity limits that a step may use.");
    v.renamed("velocity_part", "velocity_fraction");
    v("acceleration_rad_s2", acceleration_rad_s2, kPositive,
      "Acceleration of the driver's own stops and approaches (rad/s^2).");
    v("max_superposed_nm", max_superposed_nm, kNotNegative, "Max superposed torque (N m).");
    v("superposed_slope_nm_s", superposed_slope_nm_s, kPositive,
      "Fastest change of superposed torque (N m/s).");
    v("start_stiffness_nm_rad", start_stiffness_nm_rad, Range{0, 2000},
      "Joint stiffness until the first command (N m/rad).");
    v("start_damping", start_damping, kFraction, "Damping, joint and Cartesian, until the first command.");
    v("start_cart_stiffness_n_m", start_cart_stiffness_n_m, Range{0, 5000},
      "Cartesian stiffness until the first command (N/m).");
    v("start_cart_stiffness_nm_rad", start_cart_stiffness_nm_rad, Range{0, 300},
      "Rotational stiffness until the first command (N m/rad).");
    v("start_external_nm", start_external_nm, kPositive,
      "With a greater external torque at a joint command mode is not asked for (N m).");
    v("cart_velocity_m_s", cart_velocity_m_s, kPositive, "Max speed of a Cartesian command (m/s).");
    v("cart_velocity_rad_s", cart_velocity_rad_s, kPositive,
      "Max rotational speed of a Cartesian command (rad/s).");
    v("null_space_posture", null_space_posture, "Cartesian commands also carry a posture (flags 0x3501).");
    v("warm_c", warm_c, kPositive, "Drive temperature from which the arm goes slow (deg C).");
    v("hot_c", hot_c, kPositive, "Drive temperature from which command mode is left (deg C).");
    v("end_script", end_script, "Make the KRL program close FRI and end when the arm is shut down.");
  }
};

}  // namespace colift::hal
