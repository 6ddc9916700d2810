#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>

#include "sim_hal/emulator/hand/hand_gear.hpp"

namespace colift::sim_hal {

/// What a client can do wrong on a hand's bus without the hand saying so.
enum class HandRule : std::uint8_t {
  Malformed,        ///< To a puck, but no question and no setting.
  UnknownProperty,  ///< Of this firmware.
  NotReadable,      ///< Asked for a command, or for what the monitor does not know.
  NotWritable,      ///< Set what is only measured, or locked.
  Risky,            ///< SAVE, DEF, LOCK, BAUD, ID, ADDR, VALUE, MOFST: never in the field.
  Hurried,          ///< Two settings to one puck within 0.1 ms.
  Unacknowledged,   ///< Said while every puck boots or has no power: drives the sender into bus-off.
  NewEnd,           ///< Another E while the motor turns towards the last one.
  TooMuchTorque,    ///< MT above 5000.
  StreamWithStop,   ///< MODE 2, 3 or 4 while TSTOP is not 0: the puck will end it.
  FingersInTheWay,  ///< The spread turns while fingers are closed.
};
inline constexpr std::size_t kHandRules = 11;
inline constexpr std::array<std::string_view, kHandRules> kHandRuleNames{
    "malformed",       "unknown-property", "not-readable",      "not-writable",
    "risky",           "hurried",          "unacknowledged",    "new-end",
    "too-much-torque", "stream-with-stop", "fingers-in-the-way"};

/// What an emulated hand noticed so far.
struct HandEmulatorReport {
  std::uint64_t heard = 0, foreign = 0;  ///< Frames for a puck; for nobody here.
  std::uint64_t questions = 0, settings = 0, answers = 0, scans = 0;
  std::uint64_t not_sent = 0;  ///< The bus took an answer not.
  std::array<std::uint64_t, kHandRules> broken{};
  std::array<std::uint64_t, kHandRules> excused{};  ///< Broken because of a fault that was injected.
  std::array<std::string, kHandRules> first{};      ///< How each was broken for the first time.
  std::array<int, kHandPucks> initialised{};        ///< How often each puck found its stop.

  [[nodiscard]] std::uint64_t times(HandRule rule) const { return broken[static_cast<std::size_t>(rule)]; }
};

}  // namespace colift::sim_hal
