#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "hal/types/result.hpp"
#include "sim_hal/emulator/fault_text.hpp"
#include "sim_hal/emulator/hand/hand_gear.hpp"

namespace colift::sim_hal {

/// Something that goes wrong with the hand at a time.
struct HandFault : TimedFault {
  enum class Kind {
    // of answers
    Silent,     ///< The puck neither hears nor answers; its motor goes on.
    Loss,       ///< `value` percent of its answers are gone.
    Late,       ///< They come `value` ms later.
    Duplicate,  ///< They come twice.
    Corrupt,    ///< In `value` percent a bit is turned, as no real CAN does: a broken gateway.
    Wrong,      ///< They come with the next puck's identifier.
    // of a puck
    Reset,    ///< Its monitor, its zero lost.
    Error,    ///< STAT 1 with ERROR `value`.
    Hot,      ///< Puck and motor have `value` degrees Celsius.
    Stuck,    ///< Its motor does not turn.
    Freeze,   ///< Its encoder tells the same position.
    Jump,     ///< Its encoder jumps by `value` counts.
    Turn,     ///< Something turns the spread with `value` units of torque; fingers have worms.
    Weight,   ///< Something bends a finger's outer link open with `value` N m, or relieves it (negative);
              ///< its worm holds it.
    Master,   ///< Another program, node 6, sets its MT to `value`.
    Altered,  ///< Its MT is `value` from now on, and nobody saw why.
    // of all of them
    BrownOut,  ///< The supply breaks down: all are reset.
    Off,       ///< No supply: nobody acknowledges. Afterwards all are in their monitor.
    Sag,       ///< The supply gives `value` V: not yet so little that pucks reset.
    Foreign,   ///< A WAM's safety module says something 100 times a second.
    // of the client's end, which the transport has to bring about
    BusOff,
    Down,     ///< Interface down, adapter unplugged.
    Noise,    ///< Error frames, a hundred a second.
    Full,     ///< Its queue takes nothing.
    Passive,  ///< Its controller is error passive.
  };

  Kind kind = Kind::Silent;
  std::optional<std::size_t> puck;  ///< 0 to 3; unset: all.

  [[nodiscard]] bool hits(std::size_t p) const { return !puck || *puck == p; }
};

/// Reads "T:KIND[=VALUE][@PUCK][:DURATION]", times in s; PUCK F1, F2, F3, spread or 1 to 4, default all;
/// 0.5 s. Errors: BadInput, with what was expected.
[[nodiscard]] hal::Result<HandFault> parse_hand_fault(std::string_view text);

/// One entry of a scenario's `faults` for the hand. Errors: BadConfig.
[[nodiscard]] hal::Result<HandFault> hand_fault(const DeviceFaultEvent& event);

}  // namespace colift::sim_hal
