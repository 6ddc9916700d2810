#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <limits>
#include <string>
#include <vector>

#include "hal/device.hpp"
#include "hal/types/short_text.hpp"
#include "hal/types/time.hpp"

namespace colift::hal {

inline constexpr int kFingers = 3;
inline constexpr int kTactileArrays = 4;  ///< Of the fingertips F1, F2, F3, and of the palm.
inline constexpr std::size_t kPalmArray = 3;
inline constexpr std::size_t kArrayCells = 24;

/// One array of tactile cells, all of one scan. In a fingertip eight rows of three from its root, in the palm
/// rows of 5, 7, 7 and 5 from its +y side.
struct TactileArray {
  Timestamp measured_at{0};  ///< Of the scan; 0: there was none yet.
  std::array<float, kArrayCells> pressure_n_cm2 =
      no_cells();  ///< NaN without sensors, or when the last scan is old.

  static constexpr std::array<float, kArrayCells> no_cells() {
    std::array<float, kArrayCells> cells{};
    for (float& c : cells) c = std::numeric_limits<float>::quiet_NaN();
    return cells;
  }
};

/// What the hand measured. Finger joint 0 rad is fully open, about 2.44 rad fully closed.
struct HandState {
  Timestamp measured_at{0};
  std::array<double, kFingers> finger_rad{};  ///< Inner joint of F1, F2, F3.
  std::array<double, kFingers>
      outer_rad{};          ///< Outer joint against the inner link; a third of it before breakaway.
  double spread_rad = 0.0;  ///< 0: F1 and F2 opposite F3; pi: all on one side.
  std::array<double, kFingers> torque_nm{};    ///< Fingertip torque from the strain gauges; NaN without them.
  std::array<double, kFingers> tip_force_n{};  ///< Sum over the tactile pad; NaN without tactile sensors.
  std::array<TactileArray, kTactileArrays> tactile{};              ///< What the sums are made of.
  double palm_force_n = std::numeric_limits<double>::quiet_NaN();  ///< NaN without tactile sensors.
  bool moving = false;
  bool held = false;   ///< The last close() ended on contact and the grip has not been released since.
  bool slips = false;  ///< The held object moves in the grip: an alarm until release().
  bool hot = false;    ///< Too hot to grip: close() is refused; what is held is to be set down.
  /// Why a grip failed or slips; else of a hand that works all the same: warm, over torque, a bus with
  /// errors.
  ShortText warning{};
};

/// A three-finger hand whose fingers hold their position when unpowered (worm gears).
class Hand : public Device {
 public:
  /// Latest state. Errors: Timeout (no fresh answer), LinkLost, DeviceFault.
  [[nodiscard]] virtual Result<HandState> state() = 0;

  /// Starts to open the fingers and to turn the spread. Refused with NotReady while the hand holds something.
  [[nodiscard]] virtual Result<> preshape(double spread_rad) = 0;

  /// Starts to close all fingers until each is held by contact or by its stop; at most `torque_nm` at the
  /// fingertips. Returns at once: the end shows in state().moving and state().held. Errors: LimitExceeded.
  [[nodiscard]] virtual Result<> close(double torque_nm) = 0;

  /// Starts to open a loaded hand: the only call that does.
  [[nodiscard]] virtual Result<> release() = 0;

  /// What the machine granted to a thread of the hand's own, in sentences; empty where it has none.
  [[nodiscard]] virtual std::vector<std::string> realtime() const { return {}; }

  /// Fingers stay where they are. Any thread, any number of times.
  virtual void stop() noexcept = 0;
};

}  // namespace colift::hal
