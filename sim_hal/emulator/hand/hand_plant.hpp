#pragma once

#include <array>
#include <cstddef>

#include "hal/types/time.hpp"
#include "sim_hal/emulator/hand/hand_gear.hpp"

namespace colift::sim_hal {

/// What a puck does to its motor for the next millisecond. Positions are counts from the open stop, whatever
/// the puck thinks of its zero; closing is positive.
struct HandMotor {
  bool powered = false;
  double speed = 0.0;   ///< Wished (counts/ms).
  double goal = 0.0;    ///< Where the move is to end, for plants that know moves only.
  double torque = 0.0;  ///< Most it may give, in units of the puck.
};

/// What a puck's encoders and sensors have there. Index 3, the spread, has no joint encoder and no gauge.
struct HandJoint {
  double motor = 0.0;      ///< Counts from the open stop.
  double joint = 0.0;      ///< Of the inner link's worm: counts from the open stop.
  double torque = 0.0;     ///< What the motor gives (units); negative opens.
  double strain_nm = 0.0;  ///< About the outer joint; what pushes the finger open is positive.
  std::array<double, kHandCells> pressure{};  ///< Of the tactile pad (N/cm2); of the spread: the palm's.
};

/// The mechanics behind four pucks: motors, gears, links, what they touch. One thread.
class HandPlant {
 public:
  virtual ~HandPlant() = default;
  virtual void command(std::size_t puck, const HandMotor& motor) = 0;
  /// The clutch of a finger was driven against the open stop and is tight again.
  virtual void tighten(std::size_t finger) = 0;
  /// Whole milliseconds.
  virtual void advance(hal::Duration by) = 0;
  [[nodiscard]] virtual HandJoint joint(std::size_t puck) const = 0;
};

}  // namespace colift::sim_hal
