#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "sim_hal/mujoco/devices/device_faults.hpp"
#include "sim_hal/mujoco/devices/sim_devices.hpp"

namespace colift::sim_hal {
namespace {

using hal::ErrorCode;

constexpr double kMostTorque_nm = 2.0;  // above that the strain gauges' own protection would act
constexpr hal::Duration kLate = std::chrono::milliseconds(250);

/// The hand of the world behind the interface that control uses. It answers at once: waiting for it means
/// letting time pass with the arm's cycle.
class SimHand final : public hal::Hand {
 public:
  explicit SimHand(SimWorld& world) : world_(world) {}

  hal::Result<> configure() override {
    if (fault_now(world_, "hand") == Fault::Unplug) return lost("hand.configure");
    life_ = Life::Configured;
    return {};
  }

  hal::Result<> activate() override {
    if (life_ < Life::Configured)
      return fail(ErrorCode::NotReady, "hand.activate", "configure() comes first");
    if (life_ != Life::Active) world_.power_hand(true);
    life_ = Life::Active;
    return {};
  }

  void deactivate() noexcept override {
    if (life_ != Life::Active) return;
    world_.power_hand(false);
    life_ = Life::Configured;
  }

  hal::DeviceHealth health() const override {
    hal::DeviceHealth health = health_;
    switch (life_) {
      case Life::Absent:
        health.state = hal::DeviceHealth::State::Absent;
        break;
      case Life::Lost:
        health.state = hal::DeviceHealth::State::Lost;
        break;
      case Life::Configured:
        health.state = hal::DeviceHealth::State::Opening;
        break;
      case Life::Active:
        health.state = missed_ ? hal::DeviceHealth::State::Stalled : hal::DeviceHealth::State::Streaming;
        break;
    }
    return health;
  }

  hal::Result<hal::HandState> state() override {
    if (auto link = reach("hand.state"); !link) return tl::unexpected(link.error());
    const Fault fault = fault_now(world_, "hand");
    const bool fresh =
        fault != Fault::Freeze && (fault != Fault::Late || world_.clock().now() - last_.measured_at >= kLate);
    if (fresh) last_ = world_.hand_state();
    ++health_.accepted;
    hal::HandState state = last_;
    if (fault == Fault::Corrupt) state.finger_rad[1] = std::numeric_limits<double>::quiet_NaN();
    return state;
  }

  hal::Result<> preshape(double spread_rad) override {
    if (auto ready = act("hand.preshape"); !ready) return ready;
    if (!(spread_rad >= 0.0) || spread_rad > std::numbers::pi)
      return fail(ErrorCode::LimitExceeded, "hand.preshape",
                  fmt::format("a spread of {:.3f} rad; expected 0 to pi", spread_rad));
    if (world_.hand_state().held)
      return fail(ErrorCode::NotReady, "hand.preshape", "the hand holds something; release() opens it");
    world_.preshape_hand(spread_rad);
    return {};
  }

  hal::Result<> close(double torque_nm) override {
    if (auto ready = act("hand.close"); !ready) return ready;
    if (!(torque_nm > 0.0) || torque_nm > kMostTorque_nm)
      return fail(
          ErrorCode::LimitExceeded, "hand.close",
          fmt::format("a fingertip torque of {:.3f} N m; expected 0 to {:.1f}", torque_nm, kMostTorque_nm));
    world_.close_hand(torque_nm);
    return {};
  }

  hal::Result<> release() override {
    if (auto ready = act("hand.release"); !ready) return ready;
    world_.open_hand();
    return {};
  }

  void stop() noexcept override {
    if (life_ == Life::Active) world_.stop_hand();
  }

 private:
  enum class Life { Absent, Lost, Configured, Active };

  tl::unexpected<hal::Error> fail(ErrorCode code, std::string where, std::string detail) {
    health_.last_error = detail;
    return hal::failure(code, std::move(where), std::move(detail));
  }
  tl::unexpected<hal::Error> lost(std::string where) {
    return fail(ErrorCode::LinkLost, std::move(where), "the hand is not on the bus");
  }

  hal::Result<> reach(const std::string& where) {
    const Fault fault = fault_now(world_, "hand");
    if (fault == Fault::Unplug && life_ != Life::Lost) {
      world_.power_hand(false);  // without power the worm gears stay where they are
      life_ = Life::Lost;
    }
    if (life_ == Life::Lost) return lost(where);
    if (life_ == Life::Absent) return fail(ErrorCode::NotReady, where, "configure() comes first");
    missed_ = fault == Fault::Drop;
    if (!missed_) return {};
    ++health_.rejected;
    return fail(ErrorCode::Timeout, where, "no answer from the pucks");
  }

  hal::Result<> act(const std::string& where) {
    if (auto link = reach(where); !link) return link;
    if (life_ != Life::Active) return fail(ErrorCode::NotReady, where, "the hand is not active");
    return {};
  }

  SimWorld& world_;
  Life life_ = Life::Absent;
  bool missed_ = false;
  hal::HandState last_;
  hal::DeviceHealth health_;
};

}  // namespace

std::unique_ptr<hal::Hand> make_sim_hand(SimWorld& world) {
  return std::make_unique<SimHand>(world);
}

}  // namespace colift::sim_hal
