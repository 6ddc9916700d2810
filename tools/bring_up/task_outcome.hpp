#pragma once

#include <string_view>

namespace colift::tools {

/// How a bring-up task of any device ended.
enum class TaskOutcome {
  Done,
  Interrupted,  ///< Asked to end: at rest, and command mode left.
  BadRequest,   ///< The request cannot be: nothing was asked of the device.
  Refused,      ///< Not there, not initialised, or no command mode: nothing moved.
  Stopped,      ///< Arm: something was in the way; at rest, and command mode left.
  WrongLoad,    ///< Arm: its load data are wrong, or no load explains its torques; it stands as before.
  NoGrip,       ///< Hand: it closed on nothing, or the grip did not hold.
  Lost,         ///< Arm: command mode or the link went away while commanding.
  Failed,       ///< Hand: a fault while it moved; fingers stay where they are.
};
/// As documents have it: "done", "bad-request", "no-grip", ...
[[nodiscard]] std::string_view to_string(TaskOutcome outcome);
/// 0 done, 1 stopped, wrong load or without a grip, 2 bad request, 3 refused, lost or failed, 130
/// interrupted.
[[nodiscard]] int exit_code(TaskOutcome outcome);

}  // namespace colift::tools
