#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "control/arm/arm_controller.hpp"
#include "hal/arm.hpp"
#include "hal/hand.hpp"

namespace colift::telemetry {

/// What the camera gave when it was asked: a frame, by its number on /camera/frame, or why not.
struct CameraReading {
  std::optional<std::uint64_t> frame;
  hal::Error error{hal::ErrorCode::Timeout, "", ""};
};

/// Everything that the task was handed from outside in one of its cycles, in the order of each device's
/// calls. Handed in again, the same task does the same: replay.
struct CycleInputs {
  std::uint64_t cycle = 0;
  std::vector<std::int64_t> clock_ns;
  std::vector<hal::Result<hal::ArmState>> arm;  ///< Where the task itself runs the arm's cycle ...
  std::optional<control::ArmView> view;         ///< ... or what the arm's thread said.
  std::vector<hal::DeviceHealth> arm_health;
  std::vector<hal::Result<hal::HandState>> hand;
  std::vector<CameraReading> camera;
  std::vector<hal::Result<>> answers;  ///< Of arm, hand and camera to what they were told.
  bool interrupted = false, lower_confirmed = false, continue_confirmed = false;
};

/// As a message of the channel /inputs. Numbers read back to the same bits.
[[nodiscard]] std::string inputs_message(const CycleInputs& inputs);
/// Errors: BadInput with what is missing or wrong.
[[nodiscard]] hal::Result<CycleInputs> parse_inputs(std::string_view message);

}  // namespace colift::telemetry
