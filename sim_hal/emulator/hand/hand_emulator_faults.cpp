// What goes wrong with the emulated hand when it was asked for.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "sim_hal/emulator/hand/hand_emulator.hpp"

namespace colift::sim_hal {
namespace {

using Kind = HandFault::Kind;
using namespace prop;

constexpr double kSupply_v = 48.0;
constexpr double kBrake = 60.0;   // units: of the spread's gear
constexpr double kTurned = 20.0;  // counts/ms: 100 degrees/s
constexpr int kOtherMaster = 6;   // node
constexpr int kForeignEvery_ms = 10, kNoiseEvery_ms = 10;

}  // namespace

void HandEmulator::inject(const HandFault& fault) {
  config_.faults.push_back(fault);
  began_.push_back(false);
  ended_.push_back(false);
}

void HandEmulator::mend() {
  for (HandFault& fault : config_.faults) fault.end(t_s_);
  for (std::size_t p = 0; p < kHandPucks; ++p)
    if (pucks_[p].life() == HandPuck::Life::Error) reset(p, "somebody switches it off and on");
}

void HandEmulator::act(const HandFault& f, bool begins) {
  if (f.kind == Kind::BusOff || f.kind == Kind::Down || f.kind == Kind::Full || f.kind == Kind::Passive) {
    if (on_bus) on_bus(f.kind, begins);
    return;
  }
  for (std::size_t p = 0; p < kHandPucks; ++p) {
    if (!f.hits(p)) continue;
    if (f.kind == Kind::Freeze) pucks_[p].freeze(begins);
    if (f.kind == Kind::Sag) pucks_[p].supply(begins ? f.value : kSupply_v);
    if (!begins) continue;
    if (f.kind == Kind::Reset) reset(p, "on request");
    if (f.kind == Kind::BrownOut) reset(p, "the supply broke down");
    if (f.kind == Kind::Off) reset(p, "no supply");
    if (f.kind == Kind::Error) pucks_[p].fail(static_cast<int>(f.value));
    if (f.kind == Kind::Jump) pucks_[p].shift(f.value);
    const auto mt = static_cast<std::int32_t>(f.value);
    if (f.kind == Kind::Altered) (void)pucks_[p].set(kMt, mt);
    if (f.kind == Kind::Master) {
      (void)pucks_[p].set(kMt, mt);
      hal::CanFrame said;
      said.id = static_cast<std::uint16_t>(kOtherMaster << 5 | pucks_[p].node());
      said.length = 4;
      said.data = {0x80 | kMt, 0, static_cast<std::uint8_t>(mt & 255), static_cast<std::uint8_t>(mt >> 8)};
      if (bus_.send(said) != hal::CanBus::Sent::Yes) ++report_.not_sent;
    }
    const auto loses_zero = {Kind::Reset, Kind::BrownOut, Kind::Off, Kind::Error, Kind::Jump};
    faulted_[p] = faulted_[p] || std::find(loses_zero.begin(), loses_zero.end(), f.kind) != loses_zero.end();
  }
}

void HandEmulator::run_faults() {
  for (std::size_t i = 0; i < config_.faults.size(); ++i) {
    const HandFault f = config_.faults[i];
    if (f.active(t_s_) && !began_[i]) {
      began_[i] = true;
      event(fmt::format("fault begins: {}", f.text));
      act(f, true);
    }
    if (began_[i] && !ended_[i] && !f.active(t_s_)) {
      ended_[i] = true;
      event(fmt::format("fault ends: {}", f.text));
      act(f, false);
    }
    if (f.kind == Kind::Hot && f.active(t_s_))
      for (std::size_t p = 0; p < kHandPucks; ++p)
        if (f.hits(p)) pucks_[p].heat(f.value);
  }
  for (std::size_t p = 0; p < kHandFingers; ++p) {
    const HandFault* weight = active(Kind::Weight, p);
    pucks_[p].hang(weight ? weight->value : hung_nm_[p]);
  }
  if (active(Kind::Noise, 0) != nullptr && ++noise_ms_ >= kNoiseEvery_ms) {
    noise_ms_ = 0;
    if (on_bus) on_bus(Kind::Noise, true);
  }
  if (active(Kind::Foreign, 0) != nullptr && ++foreign_ms_ >= kForeignEvery_ms) {
    foreign_ms_ = 0;
    hal::CanFrame f;  // node 10 to group 0
    f.id = 0x540;
    f.length = 4;
    f.data = {0x85, 0, 0, 0};
    if (bus_.send(f) != hal::CanBus::Sent::Yes) ++report_.not_sent;
  }
}

// The spread's gear can be driven from outside: by more than the motor gives. What was turned so, the motor
// turns back first.
void HandEmulator::turn_from_outside(const HandMotor& m) {
  const double at = plant_.joint(kHandSpread).motor;
  if (const HandFault* f = active(Kind::Turn, kHandSpread)) {
    if (std::abs(f->value) > kBrake + (m.powered ? m.torque : 0.0))
      turned_ = std::clamp(turned_ + std::copysign(kTurned, f->value), -at, kSpreadStop - at);
  } else if (m.powered && m.torque > kBrake && turned_ * m.speed < 0.0) {
    turned_ += std::copysign(std::min(std::abs(m.speed), std::abs(turned_)), m.speed);
  }
}

}  // namespace colift::sim_hal
