#pragma once

#include <optional>
#include <string>
#include <vector>

#include "control/config/recovery_config.hpp"
#include "hal/arm.hpp"
#include "hal/hand.hpp"
#include "hal/robot_model/robot_model.hpp"
#include "planner/hand/hand_model.hpp"

namespace colift::control {

/// What is known after a stop, from measurements alone. Nothing moves for it.
struct Assessment {
  enum class Arm { Unknown, Moving, AtHome, Away };
  enum class Hand { Unknown, Open, Holds, Closed, Between };  ///< Closed: to the stop. Between: it may hold.

  Arm arm = Arm::Unknown;
  Hand hand = Hand::Unknown;
  std::optional<double> load_n;  ///< Along gravity, not tared; unset: unknown.
  std::string arm_words, hand_words, load_words;

  /// Nobody knows that the hand is empty.
  [[nodiscard]] bool may_hold() const { return hand != Hand::Open; }
};

/// `arm`: states over some tenths of a second, in order; `hand` empty: it did not answer.
[[nodiscard]] Assessment assess(const std::vector<hal::ArmState>& arm,
                                const std::optional<hal::HandState>& hand, const hal::JointVector& home_rad,
                                const hal::RobotModel& model, const planner::HandModel& hand_model,
                                const RecoveryConfig& config);

}  // namespace colift::control
