#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <optional>

#include "hal/arm.hpp"
#include "sim_hal/mock/fault_plan.hpp"

namespace colift::sim_hal {

/// The arm that a MockArm is: limits of a KUKA LWR 4+ unless told otherwise.
struct ArmScript {
  hal::JointVector start_rad = hal::JointVector::Zero();
  hal::JointVector limit_rad = lwr_limit_rad();            ///< Largest magnitude of a position.
  hal::JointVector velocity_rad_s = lwr_velocity_rad_s();  ///< How fast it follows.
  hal::Duration period = std::chrono::milliseconds(5);
  /// Torque from contacts over time; unset: none.
  std::function<hal::JointVector(hal::Timestamp, const hal::JointVector& q_rad)> external_nm;

  [[nodiscard]] static hal::JointVector lwr_limit_rad();
  [[nodiscard]] static hal::JointVector lwr_velocity_rad_s();
};

/// An arm without mass: it is where it was commanded, as far as its velocity allows. In lock step with a
/// clock: wait_cycle() moves the clock to the next cycle. Cycles that went by because somebody else moved the
/// clock happened without an answer. stop() may come from any thread, all else from one.
class MockArm final : public hal::Arm {
 public:
  enum class Fault {
    Freeze,  ///< The last good state again, with its old time.
    Drop,    ///< Timeout: the cycle passes, its state is lost, a command for it has no effect.
    Jump,    ///< A position that is 0.3 rad off in A2.
    Nan,     ///< A position that is NaN in A4.
    Unplug,  ///< LinkLost, until configure() and activate() are called after the fault's last cycle.
    Late,    ///< The state comes three cycles after it was measured.
  };

  /// The clock has to outlive the arm. Cycle 0 is one period after the time of construction.
  MockArm(ArmScript script, hal::ManualClock& clock);

  /// Cycles `first` to `first + count - 1` suffer the fault. Later calls win where they overlap.
  void inject(Fault fault, std::uint64_t first, std::uint64_t count = 1) {
    faults_.inject(fault, first, count);
  }

  /// Errors: BadConfig (no period, limits not positive, start outside of them), LinkLost (unplugged).
  [[nodiscard]] hal::Result<> configure() override;
  [[nodiscard]] hal::Result<> activate() override;
  void deactivate() noexcept override;
  [[nodiscard]] hal::DeviceHealth health() const override { return health_; }
  /// Also while not active: then may_command is false.
  [[nodiscard]] hal::Result<hal::ArmState> wait_cycle() override;
  /// Errors: NotReady (not active, stopped, cycle answered already), LimitExceeded (NaN, position or
  /// stiffness out of range).
  [[nodiscard]] hal::Result<> command(const hal::ImpedanceCommand& command) override;
  void stop() noexcept override { stopped_ = true; }

  /// The cycle that wait_cycle() returned last; unset before the first.
  [[nodiscard]] std::optional<std::uint64_t> cycle() const { return cycle_; }
  /// Where it truly is.
  [[nodiscard]] const hal::JointVector& q_rad() const { return q_rad_; }
  /// The last command that was accepted.
  [[nodiscard]] const std::optional<hal::ImpedanceCommand>& last_command() const { return last_command_; }

 private:
  [[nodiscard]] std::uint64_t cycles_until_now() const;
  void move(hal::Duration by);
  [[nodiscard]] bool may_command() const;
  [[nodiscard]] hal::ArmState measure() const;
  [[nodiscard]] tl::unexpected<hal::Error> drop_link(const char* where);

  ArmScript script_;
  hal::ManualClock& clock_;
  hal::Timestamp start_, moved_until_;
  FaultPlan<Fault> faults_;
  hal::JointVector q_rad_, goal_rad_;
  std::optional<hal::ImpedanceCommand> last_command_;
  std::optional<std::uint64_t> cycle_;
  std::optional<hal::ArmState> last_good_;
  bool active_ = false, answered_ = true;
  std::atomic<bool> stopped_{false};
  hal::DeviceHealth health_;
};

}  // namespace colift::sim_hal
