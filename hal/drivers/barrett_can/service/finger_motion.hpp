#pragma once

#include <functional>
#include <limits>
#include <string>

#include "hal/can_bus.hpp"
#include "hal/drivers/barrett_can/hand_config.hpp"
#include "hal/drivers/barrett_can/pucks/puck_codec.hpp"
#include "hal/types/result.hpp"
#include "hal/types/time.hpp"

namespace colift::hal {

/// What one finger is asked to do; the others and the spread stay as they are. Closing is positive.
struct FingerMotion {
  enum class Kind {
    To,        ///< `value`: angle of the inner joint (rad).
    Step,      ///< `value`: from where it is (rad).
    Velocity,  ///< `value`: of the inner joint (rad/s), for `for_s` or to an end of the range.
    Torque,    ///< `value`: at the fingertip (N m), for `for_s` or to an end of the range.
  };
  Kind kind = Kind::To;
  barrett::Puck finger = barrett::Puck::F1;
  double value = 0.0;
  double torque_nm = 0.3;  ///< Limit of the others than Torque.
  double for_s = 1.0;
  bool although_closed = false;  ///< Opens a finger of a closed hand, which may hold something.
};

struct FingerMotionEnd {
  double from_rad = 0.0, to_rad = 0.0;                              ///< Of the inner joint, by the motor.
  double max_torque_nm = std::numeric_limits<double>::quiet_NaN();  ///< Change of the gauge; NaN without one.
  double took_s = 0.0;
  bool moved = false;
  bool rests = false;     ///< MODE was read back as idle at the end.
  std::string how;        ///< Why it ended, in words.
  bool as_asked = false;  ///< To and Step: arrived; the others: the time was over, or the end of the range.
};

inline constexpr double kMaxFinger_rad = 2.39;     ///< The factory's CT.
inline constexpr double kMaxVelocity_rad_s = 0.6;  ///< Of this service: a quarter of the motor's.
inline constexpr double kMaxFor_s = 10.0;

/// Moves one finger without configuring the hand, for bring-up. The hand has to be awake, its zero known
/// (colift hal hand init) and its motors off: nothing else may drive it. Torque control has no limits of its
/// own in the puck: position, strain and time are judged here every millisecond, and the torque is renewed.
/// A program that dies leaves a finger to TSTOP and its stops, with a velocity or a torque to its stops
/// alone. Waits for the end. Errors: LimitExceeded, NotReady, DeviceFault (too hot, an error), LinkLost.
[[nodiscard]] Result<FingerMotionEnd> move_finger(
    CanBus& bus, const Clock& clock, const BarrettHandConfig& config, const FingerMotion& motion,
    const std::function<bool()>& interrupted = [] { return false; });

}  // namespace colift::hal
