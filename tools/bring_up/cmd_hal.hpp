#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "tools/cli/options.hpp"

namespace colift::tools {

/// What `hal DEVICE VERB` takes. Numbers are unset when they were not typed.
struct HalOptions {
  std::optional<std::filesystem::path> robot;  ///< Unset: the driver's defaults.
  std::string verb;
  std::optional<double> for_s;
  std::optional<std::filesystem::path> out;  ///< Of a bundle.
  bool yes = false;                          ///< Goes beyond the careful limits of bring-up.

  // arm
  std::string joint;  ///< "3" or "A3".
  double degrees = 0.0;
  double speed_deg_s = 5.0;
  double stiffness_nm_rad = 0.0;
  std::string control;                ///< Strategy of hold and move-joint; empty: the file's.
  std::vector<std::string> controls;  ///< Of switch.

  // hand
  double spread_deg = 0.0;
  std::optional<double> fingers_deg;  ///< To which the fingers close after the spread has turned.
  std::string finger;                 ///< "F2".
  double value = 0.0;                 ///< Of finger, step (deg), velocity (deg/s), torque (N m).
  double torque_nm = 0.5;
  std::vector<double> torques_nm;                ///< Of calibrate: that a person applies.
  bool press = false;                            ///< The finger presses by itself, too.
  std::optional<double> pause_s;                 ///< Steps begin by themselves, so long after they were said.
  std::optional<std::filesystem::path> bus_log;  ///< Where the bus's frames are logged.
  std::filesystem::path replay;                  ///< A log that is played.
};

/// Bring-up of the arm: state, doctor, watch, hold, move-joint, switch, load, limits, stiffness. 0 done, 1
/// came to rest because something was in the way or the load data are wrong, 2 bad request or file, 3 the arm
/// is not there, refuses, or went away, 130 interrupted.
[[nodiscard]] int cmd_hal_arm(const CommonOptions& common, const HalOptions& options);

/// Bring-up of the hand: init, state, watch, tactile, open, close, preshape, grip. Exit codes as above; 1: it
/// closed on nothing, or the grip did not hold.
[[nodiscard]] int cmd_hal_hand(const CommonOptions& common, const HalOptions& options);

/// This machine: what is found, whether it will do, and the line that repairs it. 0 nothing is bad, 3 else,
/// 2 bad file.
struct DoctorOptions {
  std::optional<std::filesystem::path> robot;  ///< Whose port and bus are looked at; unset: the defaults.
  std::filesystem::path root = "/";            ///< Where /sys, /proc and /dev are found.
};
[[nodiscard]] int cmd_doctor(const CommonOptions& common, const DoctorOptions& options);

}  // namespace colift::tools
