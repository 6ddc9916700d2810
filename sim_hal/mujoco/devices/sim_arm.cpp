#include <fmt/format.h>

#include <cmath>
#include <limits>

#include "sim_hal/mujoco/devices/device_faults.hpp"
#include "sim_hal/mujoco/devices/sim_devices.hpp"

namespace colift::sim_hal {
namespace {

using hal::ErrorCode;

constexpr int kLatePeriods = 3;
constexpr double kStepMargin = 1.05;  // of a joint's velocity limit, for rounding

/// The arm of the world behind the interface that control uses.
class SimArm final : public hal::Arm {
 public:
  explicit SimArm(SimWorld& world)
      : world_(world),
        lower_rad_(world.model().lower_rad()),
        upper_rad_(world.model().upper_rad()),
        step_rad_(world.model().velocity_rad_s() * hal::seconds(world.config().arm_period) * kStepMargin) {}

  hal::Result<> configure() override {
    if (fault_now(world_, "arm") == Fault::Unplug) return lost("arm.configure");
    life_ = Life::Configured;
    return {};
  }

  hal::Result<> activate() override {
    if (life_ < Life::Configured) return fail(ErrorCode::NotReady, "arm.activate", "configure() comes first");
    life_ = Life::Active;
    cycle_open_ = false;
    begins_ = true;
    return {};
  }

  void deactivate() noexcept override {
    stop();
    if (life_ > Life::Configured) life_ = Life::Configured;
  }

  hal::DeviceHealth health() const override {
    hal::DeviceHealth health = health_;
    health.state = life_ == Life::Lost                                   ? hal::DeviceHealth::State::Lost
                   : life_ == Life::Absent                               ? hal::DeviceHealth::State::Absent
                   : life_ == Life::Configured || life_ == Life::Stopped ? hal::DeviceHealth::State::Opening
                   : missed_                                             ? hal::DeviceHealth::State::Stalled
                             : hal::DeviceHealth::State::Streaming;
    return health;
  }

  hal::Result<hal::ArmState> wait_cycle() override {
    cycle_open_ = false;
    world_.advance(world_.config().arm_period * (fault_now(world_, "arm") == Fault::Late ? kLatePeriods : 1));
    const Fault fault = fault_now(world_, "arm");
    if (fault == Fault::Unplug && life_ != Life::Lost) {
      world_.hold_arm();  // a KRC without a client does that by itself
      life_ = Life::Lost;
    }
    if (life_ == Life::Lost) return lost("arm.wait_cycle");
    if (life_ == Life::Absent) return fail(ErrorCode::NotReady, "arm.wait_cycle", "configure() comes first");
    missed_ = fault == Fault::Drop;
    if (missed_) {
      ++health_.rejected;
      return fail(ErrorCode::Timeout, "arm.wait_cycle", "no measurement came from the controller");
    }
    ++health_.accepted;
    if (fault != Fault::Freeze) {
      last_ = world_.arm_state();
      last_.may_command = life_ == Life::Active;
    }
    cycle_open_ = true;
    hal::ArmState state = last_;
    if (fault == Fault::Corrupt) state.q_rad[3] = std::numeric_limits<double>::quiet_NaN();
    return state;
  }

  hal::Result<> command(const hal::ImpedanceCommand& command) override {
    if (life_ == Life::Lost) return lost("arm.command");
    if (life_ != Life::Active) return fail(ErrorCode::NotReady, "arm.command", "the arm is not active");
    if (!cycle_open_)
      return fail(ErrorCode::NotReady, "arm.command",
                  "one command answers one cycle, and this one is answered");
    if (auto done = check(command); !done) return done;
    cycle_open_ = begins_ = false;
    world_.command_arm(command);
    return {};
  }

  void stop() noexcept override {
    if (life_ != Life::Active) return;
    world_.hold_arm();
    life_ = Life::Stopped;
  }

 private:
  enum class Life { Absent, Lost, Configured, Stopped, Active };

  tl::unexpected<hal::Error> fail(ErrorCode code, std::string where, std::string detail) {
    health_.last_error = detail;
    return hal::failure(code, std::move(where), std::move(detail));
  }
  tl::unexpected<hal::Error> lost(std::string where) {
    return fail(ErrorCode::LinkLost, std::move(where), "the controller is not there");
  }

  // what the KRC refuses as well
  hal::Result<> check(const hal::ImpedanceCommand& c) {
    if (!c.q_rad.allFinite() || !c.stiffness_nm_rad.allFinite() || !c.damping_ratio.allFinite() ||
        !c.tau_superposed_nm.allFinite())
      return fail(ErrorCode::LimitExceeded, "arm.command", "the command holds a number that is none");
    // a client begins where the arm is, which on soft springs is beside where the last one left it
    const hal::ArmState now = world_.arm_state();
    const hal::JointVector from = begins_ ? now.q_rad : now.q_commanded_rad;
    for (int i = 0; i < hal::kArmJoints; ++i) {
      const std::string where = fmt::format("arm.command.a{}", i + 1);
      if (c.q_rad[i] < lower_rad_[i] || c.q_rad[i] > upper_rad_[i])
        return fail(ErrorCode::LimitExceeded, where,
                    fmt::format("{:.4f} rad lies outside of {:.4f} to {:.4f}", c.q_rad[i], lower_rad_[i],
                                upper_rad_[i]));
      if (std::abs(c.q_rad[i] - from[i]) > step_rad_[i])
        return fail(ErrorCode::LimitExceeded, where,
                    fmt::format("a step of {:.4f} rad in one cycle; at most {:.4f}", c.q_rad[i] - from[i],
                                step_rad_[i]));
      if (c.stiffness_nm_rad[i] < 0.0 || c.stiffness_nm_rad[i] > 2000.0 || c.damping_ratio[i] < 0.0 ||
          c.damping_ratio[i] > 1.0)
        return fail(ErrorCode::LimitExceeded, where,
                    fmt::format("stiffness {:.1f} N m/rad and damping ratio {:.2f}; 0 to 2000 and 0 to 1",
                                c.stiffness_nm_rad[i], c.damping_ratio[i]));
    }
    return {};
  }

  SimWorld& world_;
  hal::JointVector lower_rad_, upper_rad_, step_rad_;
  Life life_ = Life::Absent;
  bool cycle_open_ = false, missed_ = false, begins_ = true;
  hal::ArmState last_;
  hal::DeviceHealth health_;
};

}  // namespace

std::unique_ptr<hal::Arm> make_sim_arm(SimWorld& world) {
  return std::make_unique<SimArm>(world);
}

}  // namespace colift::sim_hal
