#include "sim_hal/mock/mock_hand.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace colift::sim_hal {

using hal::ErrorCode;
using State = hal::DeviceHealth::State;

MockHand::MockHand(HandScript script, hal::ManualClock& clock)
    : script_(std::move(script)), clock_(clock), start_(clock.now()), moved_until_(clock.now()) {}

std::uint64_t MockHand::cycle() const {
  return static_cast<std::uint64_t>(
      std::max<hal::Duration::rep>((clock_.now() - start_) / script_.period, 0));
}

tl::unexpected<hal::Error> MockHand::drop_link(const char* where) {
  active_ = false;
  motion_ = Motion::None;
  health_.state = State::Lost;
  health_.last_error = fmt::format("the hand is unplugged since {:.3f} s", hal::seconds(clock_.now()));
  return hal::failure(ErrorCode::LinkLost, where, health_.last_error);
}

hal::Result<> MockHand::configure() {
  constexpr auto kWhere = "mock_hand.configure";
  if (!(script_.closed_rad > 0 && script_.speed_rad_s > 0 && script_.max_torque_nm > 0) ||
      script_.period.count() <= 0) {
    health_.state = State::Failed;
    health_.last_error = fmt::format(
        "stop, speed, torque and period have to be above 0, found {} rad, {} rad/s, {} N m, {} ns",
        script_.closed_rad, script_.speed_rad_s, script_.max_torque_nm, script_.period.count());
    return hal::failure(ErrorCode::BadConfig, kWhere, health_.last_error);
  }
  if (faults_.at(cycle()) == Fault::Unplug) return drop_link(kWhere);
  active_ = false;
  health_.state = State::Opening;
  return {};
}

hal::Result<> MockHand::activate() {
  if (health_.state != State::Opening && health_.state != State::Streaming && health_.state != State::Stalled)
    return hal::failure(ErrorCode::NotReady, "mock_hand.activate",
                        "the hand is not open, call configure() first");
  move_until_now();
  active_ = true;
  health_.state = State::Streaming;
  return {};
}

void MockHand::deactivate() noexcept {
  stop();
  active_ = false;
  if (health_.state == State::Streaming || health_.state == State::Stalled) health_.state = State::Opening;
}

void MockHand::stop() noexcept {
  if (script_.period.count() > 0) move_until_now();
  motion_ = Motion::None;
  spread_goal_rad_ = spread_rad_;
}

hal::Result<> MockHand::ready(const char* where) {
  if (health_.state == State::Lost) return hal::failure(ErrorCode::LinkLost, where, health_.last_error);
  if (!active_) return hal::failure(ErrorCode::NotReady, where, "the hand is not active");
  if (faults_.at(cycle()) == Fault::Unplug) return drop_link(where);
  move_until_now();
  return {};
}

void MockHand::move_until_now() {
  // in steps of a cycle, so that it does not matter how often anybody looks
  while (moved_until_ + script_.period <= clock_.now()) {
    moved_until_ += script_.period;
    move_step(script_.period);
  }
}

void MockHand::move_step(hal::Duration by) {
  const double step = script_.speed_rad_s * hal::seconds(by);
  spread_rad_ += std::clamp(spread_goal_rad_ - spread_rad_, -step, step);
  if (motion_ == Motion::None) return;
  FingerAngles contact;
  contact.fill(std::numeric_limits<double>::infinity());
  if (script_.contact_rad) contact = script_.contact_rad(moved_until_);
  bool at_rest = true;
  for (std::size_t i = 0; i < finger_rad_.size(); ++i) {
    double& angle = finger_rad_[i];
    if (motion_ == Motion::Opening) {
      angle = std::max(angle - step, 0.0);
      touches_[i] = false;
      at_rest = at_rest && angle <= 0.0;
    } else {
      const double end = std::clamp(contact[i], angle, script_.closed_rad);
      angle = std::min(angle + step, end);
      touches_[i] = contact[i] <= script_.closed_rad && angle >= contact[i];
      at_rest = at_rest && angle >= end;
    }
  }
  if (!at_rest) return;
  if (motion_ == Motion::Closing) {
    held_ = touches_[2] && (touches_[0] || touches_[1]);
    motion_ = Motion::None;
  } else if (spread_rad_ == spread_goal_rad_) {
    motion_ = Motion::None;
  }
}

hal::Result<hal::HandState> MockHand::state() {
  constexpr auto kWhere = "mock_hand.state";
  if (health_.state == State::Lost) return hal::failure(ErrorCode::LinkLost, kWhere, health_.last_error);
  if (health_.state == State::Absent || health_.state == State::Failed)
    return hal::failure(ErrorCode::NotReady, kWhere, "the hand is not open, call configure() first");
  move_until_now();
  const auto fault = faults_.at(cycle());
  if (fault == Fault::Unplug) return drop_link(kWhere);
  if (fault == Fault::Drop) {
    ++health_.rejected;
    health_.state = State::Stalled;
    health_.last_error = fmt::format("no answer at {:.3f} s", hal::seconds(clock_.now()));
    return hal::failure(ErrorCode::Timeout, kWhere, health_.last_error);
  }
  ++health_.accepted;
  health_.state = active_ ? State::Streaming : State::Opening;
  hal::HandState state;
  state.measured_at = moved_until_;
  state.finger_rad = finger_rad_;
  state.spread_rad = spread_rad_;
  for (std::size_t i = 0; i < finger_rad_.size(); ++i) {
    state.outer_rad[i] = finger_rad_[i] / 3.0;
    state.torque_nm[i] = touches_[i] ? torque_nm_ : 0.0;
    state.tip_force_n[i] = std::numeric_limits<double>::quiet_NaN();
  }
  state.moving = motion_ != Motion::None || spread_rad_ != spread_goal_rad_;
  state.held = held_;
  if (!fault) {
    last_good_ = state;
  } else if (fault == Fault::Freeze) {
    if (last_good_) state = *last_good_;
  } else if (fault == Fault::Jump) {
    state.finger_rad[1] += 0.5;
  } else if (fault == Fault::Nan) {
    state.finger_rad[0] = std::numeric_limits<double>::quiet_NaN();
  } else if (fault == Fault::Late) {
    state.measured_at -= std::chrono::milliseconds(300);
  }
  return state;
}

hal::Result<> MockHand::preshape(double spread_rad) {
  constexpr auto kWhere = "mock_hand.preshape";
  if (auto done = ready(kWhere); !done) return done;
  if (held_)
    return hal::failure(ErrorCode::NotReady, kWhere, "the hand holds something, only release() opens it");
  if (!(spread_rad >= 0.0 && spread_rad <= std::numbers::pi))
    return hal::failure(ErrorCode::LimitExceeded, kWhere,
                        fmt::format("a spread of {} rad, expected 0 to pi", spread_rad));
  spread_goal_rad_ = spread_rad;
  motion_ = Motion::Opening;
  return {};
}

hal::Result<> MockHand::close(double torque_nm) {
  constexpr auto kWhere = "mock_hand.close";
  if (auto done = ready(kWhere); !done) return done;
  if (!(torque_nm > 0.0 && torque_nm <= script_.max_torque_nm))
    return hal::failure(ErrorCode::LimitExceeded, kWhere,
                        fmt::format("a torque of {} N m, expected more than 0 and at most {} N m", torque_nm,
                                    script_.max_torque_nm));
  torque_nm_ = torque_nm;
  motion_ = Motion::Closing;
  return {};
}

hal::Result<> MockHand::release() {
  if (auto done = ready("mock_hand.release"); !done) return done;
  held_ = false;
  motion_ = Motion::Opening;
  return {};
}

}  // namespace colift::sim_hal
