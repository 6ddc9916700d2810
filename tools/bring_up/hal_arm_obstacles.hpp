#pragma once

#include <string>
#include <vector>

#include "tools/bring_up/hal_arm_view.hpp"

namespace colift::tools {

/// Something that a person should know before command mode is asked for.
struct Obstacle {
  std::string kind;      ///< One word, for programs: "quality", "drives", "program", ...
  std::string what;      ///< What was found, with its numbers.
  std::string next;      ///< What to do about it.
  bool refuses = false;  ///< Command mode would be refused; else it is only worth knowing.
};

/// Why command mode would be refused now, in the order in which one mends it; then what is only worth
/// knowing.
[[nodiscard]] std::vector<Obstacle> obstacles(const ArmView& view, const hal::RobotModel& model);

/// The same as text, one line and its next step each; a sentence when nothing stands against it.
[[nodiscard]] std::string obstacles_text(const std::vector<Obstacle>& found);

/// What to do next after an arm that could not be opened: nothing came, or the port is taken.
[[nodiscard]] std::string silence_advice(const hal::FriConfig& config);

}  // namespace colift::tools
