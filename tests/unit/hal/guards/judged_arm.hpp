#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <string>

#include "hal/arm.hpp"
#include "hal/guards/cycle_time.hpp"
#include "hal/guards/guarded_arm.hpp"

namespace guards {

using namespace colift::hal;

/// Plain numbers of the limits, worked out here and not by the guard.
struct Limits {
  JointVector lower, upper, velocity, torque;
  double acceleration = 0.0, stiffness = 0.0, torque_slope = 0.0;

  Limits(const RobotModel& model, const GuardConfig& c) {
    const double margin = c.limit_margin_deg * 3.14159265358979323846 / 180.0;
    lower = model.lower_rad().array() + margin;
    upper = model.upper_rad().array() - margin;
    velocity = (c.velocity_fraction * model.velocity_rad_s()).cwiseMin(c.max_velocity_rad_s);
    torque = model.effort_nm().cwiseMin(c.max_superposed_nm);
    acceleration = c.acceleration_rad_s2;
    stiffness = c.max_stiffness_nm_rad;
    torque_slope = c.superposed_slope_nm_s;
  }
};

/// The far end of the wire: hands out the states that the test wrote, and judges every command that arrives.
class JudgedArm final : public Arm {
 public:
  explicit JudgedArm(const Limits& limits) : limits_(limits) {}

  ArmState state;                      ///< The next one.
  std::optional<ErrorCode> fail_wait;  ///< Once.
  bool fail_command = false;           ///< Once.
  bool cycle_counts = true;            ///< False for a state that came twice: nobody may answer it.
  bool restart_from_here = false;      ///< From the next state on ...
  bool must_restart = true;            ///< ... the next command has to be the measured pose.

  std::string broken;  ///< The first broken rule; empty while all is well.
  std::uint64_t commands = 0, restarts = 0, near_limit = 0;
  double fastest = 0.0;  ///< Part of the velocity limit.
  JointVector q = JointVector::Zero(), dq = JointVector::Zero(), tau = JointVector::Zero();

  Result<> configure() override { return {}; }
  Result<> activate() override {
    active_ = must_restart = true;
    time_.reset();
    return {};
  }
  void deactivate() noexcept override { active_ = false; }
  void stop() noexcept override { active_ = false; }
  DeviceHealth health() const override { return {}; }

  Result<ArmState> wait_cycle() override {
    open_ = false;
    must_restart = must_restart || restart_from_here;
    restart_from_here = false;
    if (fail_wait) {
      const ErrorCode code = *fail_wait;
      fail_wait.reset();
      return failure(code, "judge", "as asked");
    }
    if (cycle_counts) {
      time_.advance(state.measured_at);
      open_ = true;
    }
    handed_out_ = state;
    return state;
  }

  Result<> command(const ImpedanceCommand& c) override {
    if (fail_command) {
      fail_command = false;
      must_restart = true;
      open_ = false;
      return failure(ErrorCode::DeviceFault, "judge", "as asked");
    }
    ++commands;
    rule(active_, "a command to an arm that is stopped");
    rule(open_, "a cycle was answered twice, or a state that does not count");
    rule(handed_out_.may_command, "a command although none is allowed");
    open_ = false;
    rule(c.q_rad.allFinite() && c.stiffness_nm_rad.allFinite() && c.damping_ratio.allFinite() &&
             c.tau_superposed_nm.allFinite(),
         "not a number");
    if (!broken.empty()) return {};
    if (must_restart)
      restart(c);
    else
      judge_step(c);
    for (int i = 0; i < kArmJoints; ++i) {
      rule(c.stiffness_nm_rad[i] >= 0.0 && c.stiffness_nm_rad[i] <= limits_.stiffness, "stiffness");
      rule(c.damping_ratio[i] >= 0.0 && c.damping_ratio[i] <= 1.0, "damping");
      rule(std::abs(c.tau_superposed_nm[i]) <= limits_.torque[i], "superposed torque");
    }
    tau = c.tau_superposed_nm;
    return {};
  }

 private:
  void restart(const ImpedanceCommand& c) {
    rule(c.q_rad == handed_out_.q_rad, "the first command is not the measured pose");
    rule(c.tau_superposed_nm.cwiseAbs().maxCoeff() <= 1.0, "the first command pushes");
    must_restart = false;
    ++restarts;
    q = c.q_rad;
    dq.setZero();
  }

  void judge_step(const ImpedanceCommand& c) {
    constexpr double kTiny = 1e-9;
    const double dt = time_.step_s(), passed = time_.since_s();
    const JointVector v = (c.q_rad - q) / dt;
    for (int i = 0; i < kArmJoints; ++i) {
      rule(std::abs(v[i]) <= limits_.velocity[i] + kTiny, "velocity");
      rule(std::abs(c.q_rad[i] - q[i]) <= limits_.velocity[i] * passed + kTiny,
           "velocity over the real time");
      rule(std::abs(v[i] - dq[i]) <= limits_.acceleration * dt + kTiny, "acceleration");
      rule(std::abs(c.tau_superposed_nm[i] - tau[i]) <= limits_.torque_slope * dt + kTiny, "torque slope");
      // a joint that was found beyond its limit may come back, never go further
      const double top = std::max(limits_.upper[i], q[i]), bottom = std::min(limits_.lower[i], q[i]);
      rule(c.q_rad[i] <= top + kTiny && c.q_rad[i] >= bottom - kTiny, "position");
      const double way = v[i] > 0.0 ? top - c.q_rad[i] : c.q_rad[i] - bottom;
      rule(v[i] * v[i] / (2.0 * limits_.acceleration) <= way + kTiny, "cannot come to rest before its limit");
      fastest = std::max(fastest, std::abs(v[i]) / limits_.velocity[i]);
      near_limit += way < 0.02;
    }
    q = c.q_rad;
    dq = v;
  }

  void rule(bool kept, const char* name) {
    if (!kept && broken.empty()) broken = name;
  }

  Limits limits_;
  ArmState handed_out_;
  CycleTime time_;
  bool active_ = false, open_ = false;
};

}  // namespace guards
