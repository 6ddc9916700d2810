#pragma once

#include <algorithm>
#include <chrono>
#include <cmath>
#include <string>

#include "hal/arm.hpp"

/// The simplest arm that keeps the contract: each cycle of 5 ms it is where it was commanded, as far as 2
/// rad/s allow.
class OwnArm : public colift::hal::Arm {
 public:
  colift::hal::Result<> configure() override {
    open_ = true;
    return {};
  }
  colift::hal::Result<> activate() override {
    if (!open_) return refuse(Code::NotReady, "not open");
    active_ = true;
    return {};
  }
  void deactivate() noexcept override { active_ = false; }
  void stop() noexcept override { active_ = false; }
  colift::hal::DeviceHealth health() const override {
    colift::hal::DeviceHealth health;
    health.state =
        open_ ? colift::hal::DeviceHealth::State::Streaming : colift::hal::DeviceHealth::State::Absent;
    health.accepted = cycles_;
    return health;
  }

  colift::hal::Result<colift::hal::ArmState> wait_cycle() override {
    if (!open_) return refuse(Code::NotReady, "not open");
    if (!active_) goal_rad_ = q_rad_;
    q_rad_ += (goal_rad_ - q_rad_).cwiseMax(-0.01).cwiseMin(0.01);
    ++cycles_;
    answered_ = false;
    colift::hal::ArmState state;
    state.measured_at = std::chrono::milliseconds(5) * cycles_;
    state.q_rad = q_rad_;
    state.q_commanded_rad = goal_rad_;
    state.may_command = active_;
    return state;
  }

  colift::hal::Result<> command(const colift::hal::ImpedanceCommand& c) override {
    if (!active_ || answered_) return refuse(Code::NotReady, "not active, or this cycle has its command");
    const bool numbers =
        c.q_rad.allFinite() && c.stiffness_nm_rad.allFinite() && c.tau_superposed_nm.allFinite();
    if (!numbers || c.q_rad.cwiseAbs().maxCoeff() > 2.0 || c.stiffness_nm_rad.minCoeff() < 0.0 ||
        c.stiffness_nm_rad.maxCoeff() > abilities().max_stiffness_nm_rad)
      return refuse(Code::LimitExceeded, "a joint beyond 2 rad, a stiffness that it has not, or no number");
    goal_rad_ = c.q_rad;
    answered_ = true;
    return {};
  }

 private:
  using Code = colift::hal::ErrorCode;
  static tl::unexpected<colift::hal::Error> refuse(Code code, const char* why) {
    return colift::hal::failure(code, "own_arm", why);
  }

  colift::hal::JointVector q_rad_ = colift::hal::JointVector::Zero(), goal_rad_ = q_rad_;
  std::uint64_t cycles_ = 0;
  bool open_ = false, active_ = false, answered_ = true;
};
