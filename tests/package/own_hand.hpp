#pragma once

#include <algorithm>
#include <chrono>
#include <cmath>

#include "hal/hand.hpp"

/// The simplest hand that keeps the contract: fingers and spread turn with 2 rad/s, and rest at 1.2 rad on
/// something or at their stop.
class OwnHand : public colift::hal::Hand {
 public:
  explicit OwnHand(bool with_object) : rest_rad_(with_object ? 1.2 : 2.44) {}

  /// Time goes by.
  void pass(colift::hal::Duration by) {
    now_ += by;
    if (!moving_) return;
    const double step_rad = 2.0 * colift::hal::seconds(by);
    const auto turn = [&](double& angle, double goal) {
      angle += std::clamp(goal - angle, -step_rad, step_rad);
    };
    turn(finger_rad_, goal_rad_);
    turn(spread_rad_, spread_goal_rad_);
    moving_ = finger_rad_ != goal_rad_ || spread_rad_ != spread_goal_rad_;
    held_ = held_ || (!moving_ && goal_rad_ == 1.2);
  }

  colift::hal::Result<> configure() override {
    open_ = true;
    return {};
  }
  colift::hal::Result<> activate() override {
    if (!open_) return refuse(Code::NotReady, "not open");
    active_ = true;
    return {};
  }
  void deactivate() noexcept override {
    stop();
    active_ = false;
  }
  void stop() noexcept override { moving_ = false; }
  colift::hal::DeviceHealth health() const override { return {}; }

  colift::hal::Result<colift::hal::HandState> state() override {
    if (!open_) return refuse(Code::NotReady, "not open");
    colift::hal::HandState state;
    state.measured_at = now_;
    state.finger_rad.fill(finger_rad_);
    state.outer_rad.fill(finger_rad_ / 3.0);
    state.spread_rad = spread_rad_;
    state.torque_nm.fill(NAN);
    state.tip_force_n.fill(NAN);
    state.moving = moving_;
    state.held = held_;
    return state;
  }
  colift::hal::Result<> preshape(double spread_rad) override {
    if (!active_ || held_) return refuse(Code::NotReady, "not active, or it holds something");
    if (!(spread_rad >= 0.0 && spread_rad <= 3.15)) return refuse(Code::LimitExceeded, "a spread of 0 to pi");
    return move(0.0, spread_rad);
  }
  colift::hal::Result<> close(double torque_nm) override {
    if (!active_) return refuse(Code::NotReady, "not active");
    if (!(torque_nm > 0.0 && torque_nm <= 2.0)) return refuse(Code::LimitExceeded, "a torque up to 2 N m");
    return move(rest_rad_, spread_rad_);
  }
  colift::hal::Result<> release() override {
    if (!active_) return refuse(Code::NotReady, "not active");
    held_ = false;
    return move(0.0, spread_rad_);
  }

 private:
  using Code = colift::hal::ErrorCode;
  static tl::unexpected<colift::hal::Error> refuse(Code code, const char* why) {
    return colift::hal::failure(code, "own_hand", why);
  }
  colift::hal::Result<> move(double goal_rad, double spread_rad) {
    goal_rad_ = goal_rad;
    spread_goal_rad_ = spread_rad;
    moving_ = true;
    return {};
  }

  double rest_rad_;
  double finger_rad_ = 0.0, goal_rad_ = 0.0, spread_rad_ = 0.0, spread_goal_rad_ = 0.0;
  colift::hal::Timestamp now_{0};
  bool open_ = false, active_ = false, moving_ = false, held_ = false;
};
