#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <limits>
#include <optional>

#include "hal/hand.hpp"
#include "sim_hal/mock/fault_plan.hpp"

namespace colift::sim_hal {

using FingerAngles = std::array<double, hal::kFingers>;

/// What the fingers of a MockHand meet.
struct HandScript {
  /// Angle of the inner joint at which each finger meets something (rad); infinite where it meets nothing.
  /// Unset: nothing at all.
  std::function<FingerAngles(hal::Timestamp)> contact_rad;
  double closed_rad = 2.44;                              ///< The stop of a finger.
  double speed_rad_s = 2.0;                              ///< Of fingers and spread.
  double max_torque_nm = 2.0;                            ///< Largest torque at the fingertips.
  hal::Duration period = std::chrono::milliseconds(10);  ///< How often it measures; counts the cycles.
};

/// A hand whose fingers move at one speed and rest where they meet what the script says, in step with a clock
/// that the test moves. All calls come from the thread that moves the clock.
class MockHand final : public hal::Hand {
 public:
  enum class Fault {
    Freeze,  ///< The last good state again, with its old time.
    Drop,    ///< Timeout.
    Jump,    ///< F2 is 0.5 rad off.
    Nan,     ///< The angle of F1 is NaN.
    Unplug,  ///< LinkLost, until configure() and activate() are called after the fault's last cycle.
    Late,    ///< A state with a time 0.3 s in the past.
  };

  /// The clock has to outlive the hand. Cycle 0 begins at the time of construction.
  MockHand(HandScript script, hal::ManualClock& clock);

  /// Cycles `first` to `first + count - 1` suffer the fault. Later calls win where they overlap.
  void inject(Fault fault, std::uint64_t first, std::uint64_t count = 1) {
    faults_.inject(fault, first, count);
  }

  /// Errors: BadConfig (speed, period, stop or torque not positive), LinkLost (unplugged).
  [[nodiscard]] hal::Result<> configure() override;
  [[nodiscard]] hal::Result<> activate() override;
  void deactivate() noexcept override;
  [[nodiscard]] hal::DeviceHealth health() const override { return health_; }
  [[nodiscard]] hal::Result<hal::HandState> state() override;
  /// Errors: NotReady (not active, holds something), LimitExceeded (not 0 to pi).
  [[nodiscard]] hal::Result<> preshape(double spread_rad) override;
  /// Held afterwards when F3 and one of F1 and F2 met something. Errors: NotReady, LimitExceeded.
  [[nodiscard]] hal::Result<> close(double torque_nm) override;
  [[nodiscard]] hal::Result<> release() override;
  void stop() noexcept override;

 private:
  enum class Motion { None, Opening, Closing };

  [[nodiscard]] std::uint64_t cycle() const;
  [[nodiscard]] hal::Result<> ready(const char* where);
  [[nodiscard]] tl::unexpected<hal::Error> drop_link(const char* where);
  void move_until_now();
  void move_step(hal::Duration by);

  HandScript script_;
  hal::ManualClock& clock_;
  hal::Timestamp start_, moved_until_;
  FaultPlan<Fault> faults_;
  Motion motion_ = Motion::None;
  FingerAngles finger_rad_{};
  std::array<bool, hal::kFingers> touches_{};
  double spread_rad_ = 0.0, spread_goal_rad_ = 0.0, torque_nm_ = 0.0;
  bool held_ = false, active_ = false;
  std::optional<hal::HandState> last_good_;
  hal::DeviceHealth health_;
};

}  // namespace colift::sim_hal
