#include "sim_hal/mujoco/hand_drive.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "hal/types/units.hpp"

namespace colift::sim_hal {
namespace {

constexpr double kTick_s = 0.001;
// gears: 300 N m/rad between worm and link, as strong as 25 N m; the spread's is no worm but held by its
// motor
constexpr double kGear_nm_rad = 300.0, kGearDamping = 1.0, kGearStrength_nm = 25.0;
constexpr double kSpread_nm_rad = 100.0, kSpreadDamping = 0.8, kSpreadStrength_nm = 10.0;
constexpr double kInnerEnd_rad = hal::deg_to_rad(140.0);
constexpr double kOuterEnd_rad = hal::deg_to_rad(48.0);
constexpr double kCoupling = 1.0 / 3.0;
constexpr double kBrokenAway = 4.0 / 3.0;  // turn of the outer worm alone for a turn of the motor
// the motor: fastest (maker), closing at half of that so that the tips arrive softly, and how it speeds up
constexpr double kOpening_rad_s = 2.45, kClosing_rad_s = 1.2, kSpeedUp_rad_s2 = 20.0, kSpread_rad_s = 4.38;
// torque at the motor for a torque at the fingertip: the tip of a straight finger is 50 mm from the outer and
// about 120 mm from the inner joint, and a third of the turn is the outer joint's
constexpr double kMotorForTip = 2.7;
constexpr double kStalled = 0.02;  // of the closing speed
constexpr int kFingerStill_ms = 30, kAllStill_ms = 50;
constexpr double kContact_n = 0.5;
// what a motor keeps up after the grip (BarrettHandConfig: hold_torque_units over torque_units_per_nm), and
// the part of it at which the friction of its worm lets it turn on
constexpr double kHold_nm = 0.38, kTurnsOn = 0.7;
constexpr double kOneSide_rad = 2.6;      // of spread: all fingers press from one side
constexpr double kSpreadTurns_rad = 0.3;  // fingers are this far open before the spread turns

double limited(double value, double limit) {
  return std::clamp(value, -limit, limit);
}

double gear_torque(double wound_rad, double winding_rad_s) {
  return limited(kGear_nm_rad * wound_rad + kGearDamping * winding_rad_s, kGearStrength_nm);
}

double towards(double value, double goal, double step) {
  return value + std::clamp(goal - value, -step, step);
}

}  // namespace

void HandDrive::preshape(double spread_rad) {
  open();
  spread_goal_rad_ = std::clamp(spread_rad, 0.0, std::numbers::pi);
}

void HandDrive::open(const std::array<bool, hal::kFingers>& which) {
  mode_ = Mode::Opening;
  opens_ = which;
  held_ = false;
  for (Finger& finger : fingers_) finger.speed_rad_s = 0.0;
}

void HandDrive::stop() {
  if (mode_ != Mode::Pressing) mode_ = Mode::Still;
}

void HandDrive::power(bool on) {
  mode_ = on && held_ ? Mode::Pressing : Mode::Still;
}

bool HandDrive::turns() const {
  return std::any_of(fingers_.begin(), fingers_.end(),
                     [](const Finger& f) { return f.inner_rad_s != 0.0 || f.outer_rad_s != 0.0; });
}

void HandDrive::close(const std::array<double, hal::kFingers>& torque_nm) {
  mode_ = Mode::Closing;
  limit_nm_ = torque_nm;
  still_ms_ = 0;
  for (Finger& finger : fingers_) {
    finger.speed_rad_s = 0.0;
    finger.still_ms = 0;
  }
}

bool HandDrive::at_end(const Finger& finger) {
  return finger.broken_away ? finger.outer_rad >= kOuterEnd_rad : finger.inner_rad >= kInnerEnd_rad;
}

double HandDrive::load_of(std::size_t f, double limit_nm, const HandReading& reading,
                          const HandTorque& gears) const {
  const double motor = fingers_[f].broken_away
                           ? gears.outer_nm[f] / limit_nm
                           : (gears.inner_nm[f] + kCoupling * gears.outer_nm[f]) / (kMotorForTip * limit_nm);
  return std::max(motor, reading.strain_nm[f] / limit_nm);
}

void HandDrive::turn_closing(Finger& finger, double load) {
  const double free = std::clamp(1.0 - load, 0.0, 1.0);
  finger.speed_rad_s = std::min(finger.speed_rad_s + kSpeedUp_rad_s2 * kTick_s, kClosing_rad_s * free);
  const double turn = finger.speed_rad_s * kTick_s;
  if (!finger.broken_away) finger.inner_rad = std::min(finger.inner_rad + turn, kInnerEnd_rad);
  finger.outer_rad = finger.broken_away
                         ? std::min(finger.outer_rad + kBrokenAway * turn, kOuterEnd_rad)
                         : std::min(std::max(kCoupling * finger.inner_rad, finger.outer_rad), kOuterEnd_rad);
  finger.still_ms =
      at_end(finger) || finger.speed_rad_s < kStalled * kClosing_rad_s ? finger.still_ms + 1 : 0;
}

void HandDrive::close_finger(std::size_t f, const HandReading& reading, const HandTorque& gears) {
  Finger& finger = fingers_[f];
  const double limit_nm = limit_nm_[f];
  if (!(limit_nm > 0.0)) {
    finger.still_ms = kFingerStill_ms;
    return;
  }
  turn_closing(finger, load_of(f, limit_nm, reading, gears));
  if (finger.still_ms < kFingerStill_ms || finger.broken_away || at_end(finger)) return;
  if (reading.link_force_n[f] > kContact_n && reading.strain_nm[f] < 0.5 * limit_nm) {
    finger.broken_away = true;
    finger.still_ms = 0;
  }
}

// What gives way by tenths of a millimetre would else take all force from a locked finger.
void HandDrive::press_finger(std::size_t f, const HandReading& reading, const HandTorque& gears) {
  Finger& finger = fingers_[f];
  const double limit_nm = std::min(limit_nm_[f], kHold_nm);
  if (!(limit_nm > 0.0)) return;
  const double load = load_of(f, limit_nm, reading, gears);
  if (finger.speed_rad_s == 0.0) {
    if (load > kTurnsOn) return;
    finger.still_ms = 0;
  }
  turn_closing(finger, load);
  if (finger.still_ms >= kFingerStill_ms) finger.speed_rad_s = 0.0;
}

// As the driver judges it: with F3 against one of the others, or two of three.
bool HandDrive::closed_through() const {
  const auto shut = [](const Finger& finger) { return finger.inner_rad >= kInnerEnd_rad; };
  return std::count_if(fingers_.begin(), fingers_.end(), shut) > 1 ||
         (spread_rad_ < kOneSide_rad && shut(fingers_[2]));
}

bool HandDrive::open_finger(Finger& finger) {
  finger.speed_rad_s = std::min(finger.speed_rad_s + kSpeedUp_rad_s2 * kTick_s, kOpening_rad_s);
  const double turn = finger.speed_rad_s * kTick_s;
  if (finger.broken_away) {
    finger.outer_rad -= kBrokenAway * turn;
    finger.broken_away = finger.outer_rad > kCoupling * finger.inner_rad;
  } else {
    finger.inner_rad = std::max(finger.inner_rad - turn, 0.0);
    finger.outer_rad = kCoupling * finger.inner_rad;
  }
  return finger.inner_rad > 0.0;
}

HandTorque HandDrive::tick(const HandReading& reading) {
  HandTorque torque;
  bool opening = false, all_still = true, touching = false;
  double most_closed = 0.0;
  for (int i = 0; i < hal::kFingers; ++i) {
    const auto f = static_cast<std::size_t>(i);
    Finger& finger = fingers_[f];
    torque.inner_nm[f] =
        gear_torque(finger.inner_rad - reading.inner_rad[f], finger.inner_rad_s - reading.inner_rad_s[f]);
    torque.outer_nm[f] =
        gear_torque(finger.outer_rad - reading.outer_rad[f], finger.outer_rad_s - reading.outer_rad_s[f]);
    const double inner_rad = finger.inner_rad, outer_rad = finger.outer_rad;
    if (mode_ == Mode::Closing) close_finger(f, reading, torque);
    if (mode_ == Mode::Pressing) press_finger(f, reading, torque);
    if (mode_ == Mode::Opening && opens_[f]) opening = open_finger(finger) || opening;
    finger.inner_rad_s = (finger.inner_rad - inner_rad) / kTick_s;
    finger.outer_rad_s = (finger.outer_rad - outer_rad) / kTick_s;
    all_still = all_still && finger.still_ms >= kFingerStill_ms;
    touching = touching || reading.link_force_n[f] > kContact_n;
    most_closed = std::max(most_closed, finger.inner_rad);
  }
  if (mode_ == Mode::Opening && most_closed < kSpreadTurns_rad)
    spread_rad_ = towards(spread_rad_, spread_goal_rad_, kSpread_rad_s * kTick_s);
  for (std::size_t s = 0; s < 2; ++s) {
    torque.spread_nm[s] = limited(
        kSpread_nm_rad * (spread_rad_ - reading.spread_rad[s]) - kSpreadDamping * reading.spread_rad_s[s],
        kSpreadStrength_nm);
  }
  if (mode_ == Mode::Opening && !opening && spread_rad_ == spread_goal_rad_) mode_ = Mode::Still;
  if (mode_ == Mode::Closing) {
    still_ms_ = all_still ? still_ms_ + 1 : 0;
    if (still_ms_ >= kAllStill_ms) {
      held_ = touching;
      mode_ = held_ ? Mode::Pressing : Mode::Still;
      if (held_) ++grasps_;
    }
  } else if (mode_ == Mode::Pressing && closed_through()) {
    mode_ = Mode::Still;
    held_ = false;
  }
  return torque;
}

}  // namespace colift::sim_hal
