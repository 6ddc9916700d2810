#pragma once

#include <functional>
#include <string>
#include <vector>

#include "hal/can_bus.hpp"
#include "hal/drivers/barrett_can/calibration/hand_calibration.hpp"
#include "hal/drivers/barrett_can/hand_config.hpp"
#include "hal/drivers/barrett_can/pucks/puck_codec.hpp"
#include "hal/types/result.hpp"
#include "hal/types/time.hpp"

namespace colift::tools {

/// What is measured of one finger.
struct FingerCalibration {
  hal::barrett::Puck finger = hal::barrett::Puck::F1;
  std::vector<double> torques_nm;  ///< That a person applies about the outer joint, one after the other.
  bool press = false;              ///< Then the finger presses on something rigid by itself.
  std::string date;
};

struct FingerCalibrated {
  hal::PuckScale scale;
  std::vector<hal::ScalePoint> strain, torque;  ///< N m applied and shown; units of the motor and N m.
};

/// Says what to do and returns when it is done; an error ends the calibration.
using AskPerson = std::function<hal::Result<>(const std::string& words)>;

/// Reads the gauge without load and with each of the torques; then, where asked, closes the finger onto
/// something rigid with rising torque limits and reads what the gauge shows of each; at the end the finger
/// opens a little. Errors: BadInput (torques; points that lie on no line), of `ask`, and of reading and
/// moving the finger.
[[nodiscard]] hal::Result<FingerCalibrated> calibrate_finger(hal::CanBus& bus, const hal::Clock& clock,
                                                             const hal::BarrettHandConfig& config,
                                                             const FingerCalibration& what,
                                                             const AskPerson& ask);

[[nodiscard]] std::string calibration_text(hal::barrett::Puck finger, const FingerCalibrated& result);
/// Document colift.hal.hand/1.
[[nodiscard]] std::string calibration_document(hal::barrett::Puck finger, const FingerCalibrated& result);

}  // namespace colift::tools
