#pragma once

#include <optional>
#include <span>
#include <string_view>

namespace colift::control {

/// Steps of a recovery after a stop. Each of Lower, TakeOver, Release, DrawBack and Home is begun on an
/// operator's confirmation only.
enum class RecoveryStep {
  Assess,    ///< Nothing moves: what state arm, hand and load are in.
  Lower,     ///< The palm goes straight down until the object is supported.
  TakeOver,  ///< The arm holds still until a person bears the object.
  Release,   ///< Opens the hand: the only step that does.
  DrawBack,  ///< The open hand goes straight back, away from the object.
  Home,      ///< To the position where a job begins.
  Done,      ///< End: at home, hand open.
  Held,      ///< End: the arm holds its position, the grip is as it is; a person has to decide.
};

enum class RecoveryEvent {
  HandHolds,    ///< The hand holds something, or may: nobody knows that it does not.
  HandOpen,     ///< Every finger is open.
  AtHome,       ///< And the arm is where a job begins.
  HandUnknown,  ///< The hand does not answer.
  Supported,    ///< Something or somebody bears the object: the hand hardly does.
  PersonHolds,  ///< The operator says that a person holds the object.
  NoGround,     ///< Lowered as far as allowed, and the load is still there.
  EndOfReach,
  HandOpened,
  Clear,       ///< The hand is away from the object.
  Obstructed,  ///< Unexpected contact of the open hand, or fingers that did not open: tried once more.
  Blocked,     ///< The same again.
  Declined,    ///< The operator did not confirm.
  Interrupted,
  DeviceLost,  ///< Arm or hand.
  TimeOut,
};

struct RecoveryRule {
  RecoveryStep from;
  RecoveryEvent on;
  RecoveryStep to;
  std::string_view reason;
};

inline constexpr int kRecoverySteps = static_cast<int>(RecoveryStep::Held) + 1;
inline constexpr int kRecoveryEvents = static_cast<int>(RecoveryEvent::TimeOut) + 1;

/// The whole recovery as a table.
[[nodiscard]] std::span<const RecoveryRule> recovery_rules();
/// The rule for an event in a step; nullopt: the event means nothing there. Pure.
[[nodiscard]] std::optional<RecoveryRule> next(RecoveryStep now, RecoveryEvent event);

[[nodiscard]] std::string_view word(RecoveryStep step);
[[nodiscard]] std::string_view word(RecoveryEvent event);
[[nodiscard]] bool is_end(RecoveryStep step);

}  // namespace colift::control
