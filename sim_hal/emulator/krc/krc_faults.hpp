#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "hal/types/result.hpp"
#include "sim_hal/emulator/fault_text.hpp"

namespace colift::sim_hal {

/// Something that goes wrong at a time.
struct KrcFault : TimedFault {
  enum class Kind {
    // of the wire
    Loss,       ///< All; `value` in a row; or `value` percent.
    Delay,      ///< By `value` ms.
    Reorder,    ///< Neighbours change places.
    Duplicate,  ///< Everything arrives twice.
    Corrupt,    ///< A byte is turned, or the end is missing.
    Burst,      ///< `value` datagrams are held back and come at once.
    // of the controller
    Quality,        ///< No better than `value` (0 unacceptable ... 3 perfect), whatever the answers are.
    Monitor,        ///< Out of command mode, drives stay on.
    EmergencyStop,  ///< Out of command mode, brakes, drives off; the program halts until it is started anew.
    DriveError,     ///< Of `joint`: as an emergency stop, with its error bit.
    DriveWarning,   ///< Of `joint`: its warning bit.
    DrivesOff,      ///< Power 0 without leaving command mode.
    Temperature,    ///< Of all drives: `value` degrees Celsius.
    Freeze,         ///< The same measurement again under new counters.
    Jump,           ///< The measured position of `joint` is off by `value` rad.
    NotANumber,     ///< The measured position of `joint` is NaN.
    TorqueOffset,   ///< The torque sensor of `joint` is off by `value` N m.
    Contact,        ///< A push of `value` N down on the tool.
    LoadData,       ///< What hangs on the tool is `value` kg more than the KRC's load data say.
    Unplug,         ///< The controller is switched off and on again.
  };
  enum class Direction { Both, ToKrc, ToClient };

  Kind kind = Kind::Loss;
  Direction way = Direction::Both;
  bool percent = false;  ///< Of `value`.
  bool counted = false;  ///< Ends after `value` datagrams and not after a time.
  int joint = 3;         ///< From 0.

  [[nodiscard]] bool on_wire() const { return kind <= Kind::Burst; }
};

/// Reads "T:KIND[.in|.out][=VALUE[%]][@JOINT][:DURATION]", times in s; .in is what the controller receives,
/// .out what it sends; default both ways (a counted loss: .in), 0.5 s. Errors: BadInput, with what was
/// expected.
[[nodiscard]] hal::Result<KrcFault> parse_krc_fault(std::string_view text);

/// One entry of a scenario's `faults` for the arm. Errors: BadConfig.
[[nodiscard]] hal::Result<KrcFault> krc_fault(const DeviceFaultEvent& event);

}  // namespace colift::sim_hal
