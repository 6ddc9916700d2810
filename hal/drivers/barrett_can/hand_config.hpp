#pragma once

#include <string>

#include "hal/config/range.hpp"

namespace colift::hal {

/// The BarrettHand on its bus. Torques in the pucks' own units (motor current); "N m" is always at a
/// fingertip.
struct BarrettHandConfig {
  std::string can = "socketcan:can0";
  std::string initialise = "when-needed";
  std::string tactile = "full";
  std::string bus_log;
  std::string calibration_file;

  double max_torque_nm = 1.0;
  double torque_units_per_nm = 2900.0;
  double min_torque_units = 700.0;
  double move_torque_units = 2200.0;
  double hold_torque_units = 1100.0;
  double warm_hold_torque_units = 500.0;
  bool stop_on_strain = true;

  double finger_speed_rad_s = 2.45;
  double spread_speed_rad_s = 4.3;

  double warn_c = 60.0;
  double limit_c = 65.0;

  double reply_ms = 8.0;
  double measure_ms = 10.0;
  double status_ms = 50.0;
  double tactile_ms = 10.0;
  double tactile_reply_ms = 60.0;
  double temperature_ms = 400.0;
  double stale_s = 0.1;

  double boot_s = 1.0;
  double wake_s = 2.0;
  double finger_initialise_s = 10.0;
  double spread_initialise_s = 6.0;
  double move_s = 6.0;
  double still_s = 0.5;
  double stopped_ms = 100.0;
  double verify_s = 0.15;
  double press_ms = 1000.0;
  double reopen_s = 1.0;

  double contact_nm = 0.08;
  double contact_n = 0.3;
  double slip_rad = 0.03;
  double slip_share = 0.5;
  double slip_pattern_mm = 4.0;
  double spread_slip_rad = 0.1;

  template <class Visitor>
  void visit(Visitor& v) {
    constexpr Range kUnits{0.0, 5000.0};
    constexpr Range kMs{1.0, 10'000.0};
    v("can", can, "Its bus: socketcan:can0, or socketcand:host:port/can0 for a gateway.");
    v("initialise", initialise, Choices{"when-needed", "always", "never"},
      "Whether configure() may open the hand to its stops to find its zero.");
    v("tactile", tactile, Choices{"full", "top10", "off"},
      "Format of the tactile pads; top10 is quicker and coarser.");
    v("bus_log", bus_log,
      "File in which every frame of the bus is logged (candump -L -x), numbered if it exists; empty: none.");
    v("calibration_file", calibration_file,
      "Scales of gauges and motors by the pucks' serial numbers, of colift hal hand calibrate; empty: the "
      "maker's curve and torque_units_per_nm.");
    v("max_torque_nm", max_torque_nm, kPositive, "Max closing torque at the fingertips (N m).");
    v("torque_units_per_nm", torque_units_per_nm, kPositive,
      "Units of a puck for 1 N m at the fingertip; to be measured on the hand.");
    v("min_torque_units", min_torque_units, kUnits, "Below it a finger does not overcome its friction.");
    v.renamed("least_torque_units", "min_torque_units");
    v("move_torque_units", move_torque_units, kUnits, "Torque limit of free moves, and of closing.");
    v("hold_torque_units", hold_torque_units, kUnits, "Most torque that is kept up while something is held.");
    v("warm_hold_torque_units", warm_hold_torque_units, kUnits, "The same above warn_c.");
    v("stop_on_strain", stop_on_strain, "The puck itself stops a closing finger at the wished strain.");
    v("finger_speed_rad_s", finger_speed_rad_s, Range{0.1, 3.0}, "Of the inner links.");
    v("spread_speed_rad_s", spread_speed_rad_s, Range{0.1, 5.0}, "Of the spread.");
    v("warn_c", warn_c, Range{20, 100}, "From here on less torque is kept up (C).");
    v("limit_c", limit_c, Range{20, 100},
      "From here on the hand closes no more (C); the maker's limit is 65.");
    v("reply_ms", reply_ms, kMs,
      "A question without answer is asked again after this; after three a puck is silent.");
    v("measure_ms", measure_ms, kMs, "Period of positions and strains.");
    v("status_ms", status_ms, kMs, "Period of status and mode.");
    v("tactile_ms", tactile_ms, kMs, "Period of the tactile pads, if they are as quick.");
    v("tactile_reply_ms", tactile_reply_ms, kMs, "A scan that is not complete by then is asked for again.");
    v("temperature_ms", temperature_ms, kMs, "Period of the temperatures.");
    v("stale_s", stale_s, kPositive, "Positions older than this are no state (s).");
    v("boot_s", boot_s, kPositive, "Silence on the bus after waking pucks: none of them acknowledges (s).");
    v("wake_s", wake_s, kPositive, "Timeout for the first answer after that (s).");
    v("finger_initialise_s", finger_initialise_s, kPositive,
      "Timeout for the fingers to find their stops (s).");
    v("spread_initialise_s", spread_initialise_s, kPositive, "The same for the spread (s).");
    v("move_s", move_s, kPositive, "Timeout for any other move (s).");
    v("still_s", still_s, kPositive, "A finger that does not move for this long does not move (s).");
    v("stopped_ms", stopped_ms, Range{20, 1000}, "A puck ends its move after this long without motion (ms).");
    v("verify_s", verify_s, kPositive, "Time for which a grip has to be measured before it counts (s).");
    v("press_ms", press_ms, Range{200, 30'000},
      "A pressing finger's motor rests this long after the driver's last word: its worm holds (ms).");
    v("reopen_s", reopen_s, Range{0.1, 60}, "A lost bus is opened again no more often than this (s).");
    v("contact_nm", contact_nm, kPositive, "Strain above idle that counts as contact (N m).");
    v.renamed("felt_nm", "contact_nm");
    v("contact_n", contact_n, kPositive, "Force on a pad that counts as contact (N).");
    v.renamed("felt_n", "contact_n");
    v("slip_rad", slip_rad, kPositive,
      "Holding fingers that close by this much in the mean have slipped (rad).");
    v("slip_share", slip_share, kFraction, "A grip force that falls to this share at once is a slip.");
    v("slip_pattern_mm", slip_pattern_mm, Range{1.0, 50.0},
      "The centre of pressure of two tactile arrays that moves by this much is a slip (mm).");
    v("spread_slip_rad", spread_slip_rad, kPositive,
      "A loaded spread that turns by this much has given way: it has no worm gear (rad).");
  }
};

}  // namespace colift::hal
