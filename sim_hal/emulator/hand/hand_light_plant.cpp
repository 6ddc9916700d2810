#include "sim_hal/emulator/hand/hand_light_plant.hpp"

#include <algorithm>
#include <cmath>

#include "hal/types/units.hpp"

namespace colift::sim_hal {
namespace {

constexpr hal::Duration kTick = std::chrono::milliseconds(1);
constexpr double kTip_m = 0.05;  // from the outer joint to the pad's middle
// cells 7 to 15, the flat middle of the pad; the middle column gets twice as much
constexpr std::size_t kFirstTouched = 6, kBehindTouched = 15;

double stop_of(std::size_t puck) {
  return puck == kHandSpread ? kSpreadStop : kFingerStop;
}

// Distance of a pad from the middle of the hand before breakaway (maker's Denavit-Hartenberg table).
double pad_radius_m(double inner_rad) {
  const double bent = inner_rad * 4.0 / 3.0 + hal::deg_to_rad(42.0);
  return 0.050 + 0.070 * std::cos(inner_rad) + 0.050 * std::cos(bent) - 0.0095 * std::sin(bent);
}

}  // namespace

HandObject HandObject::of_width(double width_m) {
  HandObject object;
  double open = 0.0, closed = 1.9;  // the pads come nearer all the way
  if (pad_radius_m(open) < 0.5 * width_m) return object;
  while (closed - open > 1e-6) {
    const double middle = 0.5 * (open + closed);
    (pad_radius_m(middle) > 0.5 * width_m ? open : closed) = middle;
  }
  object.total_rad.fill(open * 4.0 / 3.0);
  return object;
}

void LightHandPlant::place(std::size_t puck, double motor) {
  fingers_[puck] = {};
  fingers_[puck].motor = std::clamp(motor, 0.0, stop_of(puck));
}

double LightHandPlant::inner_rad(const Finger& finger, double motor) const {
  return finger.frozen_at.value_or(motor) / kInnerCounts_rad;
}

double LightHandPlant::pad_nm(std::size_t finger, double motor) const {
  const auto& touches = object_.total_rad[finger];
  return touches ? config_.pad_nm_rad * std::max(0.0, motor / kTotalCounts_rad - *touches) : 0.0;
}

double LightHandPlant::inner_nm(std::size_t finger, double motor) const {
  const auto& touches = object_.inner_rad[finger];
  return touches ? config_.inner_nm_rad * std::max(0.0, inner_rad(fingers_[finger], motor) - *touches) : 0.0;
}

double LightHandPlant::load(std::size_t puck, double motor) const {
  if (puck == kHandSpread) return 0.0;
  if (fingers_[puck].frozen_at) return config_.freed_units_nm * pad_nm(puck, motor);
  return config_.tip_units_nm * pad_nm(puck, motor) + config_.inner_units_nm * inner_nm(puck, motor);
}

void LightHandPlant::tick(std::size_t puck) {
  Finger& f = fingers_[puck];
  const HandMotor& m = motors_[puck];
  f.torque = 0.0;
  if (!m.powered || m.speed == 0.0) return;
  const double friction = puck == kHandSpread ? config_.spread_friction : config_.finger_friction;
  const double left = m.torque - friction;  // for the load
  const double sign = m.speed > 0.0 ? 1.0 : -1.0;
  const double before = f.motor;
  if (left > 0.0) {
    double to = f.motor + std::clamp(m.speed, -config_.most_speed, config_.most_speed);
    to = std::clamp(to, 0.0, stop_of(puck));
    if (sign > 0.0 && load(puck, to) > left) {
      double low = f.motor, high = to;
      if (load(puck, low) > left) high = low;
      while (high - low > 0.01) {
        const double middle = 0.5 * (low + high);
        (load(puck, middle) > left ? high : low) = middle;
      }
      to = low;
    }
    f.motor = to;
  }
  const bool blocked = std::abs(f.motor - before) < 0.5 * std::abs(m.speed);
  f.torque =
      sign * (blocked ? m.torque : std::min(m.torque, friction + (sign > 0 ? load(puck, f.motor) : 0.0)));
  if (puck == kHandSpread) return;
  if (!f.frozen_at && inner_nm(puck, f.motor) >= config_.breakaway_nm) f.frozen_at = f.motor;
  // on the way back the outer link first, then both
  if (f.frozen_at && f.motor < *f.frozen_at) f.frozen_at.reset();
}

void LightHandPlant::advance(hal::Duration by) {
  for (auto ticks = by / kTick; ticks > 0; --ticks)
    for (std::size_t puck = 0; puck < kHandPucks; ++puck) tick(puck);
}

HandJoint LightHandPlant::joint(std::size_t puck) const {
  const Finger& f = fingers_[puck];
  HandJoint j;
  j.motor = f.motor;
  j.torque = f.torque;
  if (puck == kHandSpread) {
    for (std::size_t cell = 0; cell < kHandCells; ++cell)
      j.pressure[cell] = object_.palm_n / (hand_cell_cm2(true, cell) * kHandCells);
    return j;
  }
  j.joint = inner_rad(f, f.motor) * kWormCounts_rad;
  j.strain_nm = pad_nm(puck, f.motor);
  double weight_cm2 = 0.0;
  const auto share = [](std::size_t cell) { return cell % 3 == 1 ? 2.0 : 1.0; };
  const std::size_t moved = 3 * std::min<std::size_t>(object_.pad_rows, 3);
  const std::size_t first = kFirstTouched + moved, behind = kBehindTouched + moved;
  for (std::size_t cell = first; cell < behind; ++cell)
    weight_cm2 += share(cell) * hand_cell_cm2(false, cell);
  for (std::size_t cell = first; cell < behind; ++cell)
    j.pressure[cell] = share(cell) * j.strain_nm / kTip_m / weight_cm2;
  return j;
}

}  // namespace colift::sim_hal
