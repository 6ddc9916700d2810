// The grip: from fingers that have stopped to one that is held, and watched.
#include <cmath>
#include <numbers>

#include "hal/drivers/barrett_can/hand_motion.hpp"

namespace colift::hal::barrett {
namespace {

constexpr double kOneSide_rad = 2.6;  // of spread: all fingers press from one side, against the palm
constexpr double kOpposed_rad = std::numbers::pi / 3;  // of spread: up to here F1 and F2 press against F3
// Of the torque that a finger keeps up, measured at its gauge: less is no grip. The units per N m of a motor
// are known to a third.
constexpr double kHeldFraction = 0.4;
constexpr double kRelaxed_nm = 0.5;  // a finger that its puck let off presses again below

}  // namespace

bool HandMotion::measured(Puck finger, Timestamp now) const {
  const Reported& p = link_.reported(finger, Property::P);
  const Reported& joint = link_.reported(finger, Property::Jp);
  // comparisons with NaN are false
  return strain_above_idle(link_, facts_, finger) > config_.contact_nm ||
         pad_force(link_, facts_, finger, now) > config_.contact_n ||
         broken_away(p.value, joint.known ? std::optional(joint.value) : std::nullopt);
}

// F3 bears what F1 and F2 press: no fingertip may get more than was wished, and no gauge more than it stands.
double HandMotion::share(Puck finger) const {
  const double spread_rad = position(Puck::Spread) / kSpreadCounts_rad;
  if (finger == Puck::F3 || spread_rad >= kOpposed_rad) return 1.0;
  return 0.5 / std::cos(spread_rad);
}

// The motor goes on pressing against what stopped it: without TSTOP the puck never ends the move.
void HandMotion::press(Puck finger) {
  rests_[index(finger)] = false;
  link_.drop_settings(finger);
  link_.set(finger, Property::Mt, static_cast<std::int32_t>(hold_units_[index(finger)]), true);
  link_.set(finger, Property::Tstop, 0, true);
  if (facts_.has_strain) link_.set(finger, Property::Hsg, 0, true);
  link_.set(finger, Property::E, kClosedCounts, true);
  link_.set(finger, Property::Mode, kModeTrapezoid, false);
}

void HandMotion::press() {
  pressing_ = true;
  for (const Puck finger : kFingerPucks)
    if (contact_[index(finger)]) press(finger);
}

void HandMotion::rest(Puck finger) {
  rests_[index(finger)] = true;
}

// What slips is gripped with all that the motors may give, once; a hot hand does not.
void HandMotion::grip_up() {
  if (gripped_up_ || hold_limit_units_ < config_.hold_torque_units) return;
  gripped_up_ = true;
  for (const Puck finger : kFingerPucks)
    hold_units_[index(finger)] =
        std::clamp(share(finger) * config_.max_torque_nm * config_.torque_units_per_nm,
                   hold_units_[index(finger)], config_.move_torque_units);
  press();
}

void HandMotion::after_closing(Timestamp now) {
  bool failed = false;  // a finger that does not work leaves less of a grip than was planned
  for (const Puck finger : kFingerPucks) {
    const End end = moves_[index(finger)].end;
    bool& contact = contact_[index(finger)];
    contact = end == End::Stalled || (end == End::NoMotion && (contact || measured(finger, now)));
    failed = failed || (end != End::Reached && !contact);
  }
  if (failed || !opposed()) {
    give_up_grip();
    return;
  }
  loaded_ = true;
  phase_ = Phase::Verifying;
  verify_timed_ = false;
  press_tries_ = 0;
  if (hold_limit_units_ > 0.0) press();
}

bool HandMotion::opposed() const {
  const int count = static_cast<int>(std::count(contact_.begin(), contact_.end(), true));
  if (position(Puck::Spread) / kSpreadCounts_rad > kOneSide_rad) return count >= 2;
  return contact_[index(Puck::F3)] && count >= 2;
}

// Nobody opens the hand here: what it may still touch stays as it is until release().
void HandMotion::give_up_grip() {
  pressing_ = false;
  for (const Puck finger : kFingerPucks) let_rest(finger);
  loaded_ = loaded_ && std::any_of(contact_.begin(), contact_.end(), [](bool c) { return c; });
  phase_ = Phase::Still;
  if (why_.empty())
    say(why_, "the fingers closed on nothing: {} {} {}", contact_[0] ? "F1 touches" : "F1 free",
        contact_[1] ? "F2 touches" : "F2 free", contact_[2] ? "F3 touches" : "F3 free");
}

// MODE is a setting that nobody acknowledges: a finger that was to press and is idle is told again.
bool HandMotion::press_again() {
  bool again = false;
  for (const Puck finger : kFingerPucks) {
    const Reported& mode = link_.reported(finger, Property::Mode);
    const bool idle = mode.asked_at > link_.mode_set_at(finger) && mode.value != kModeTrapezoid;
    if (!pressing_ || !contact_[index(finger)] || !idle || position(finger) >= kClosedCounts - kNear)
      continue;
    link_.set(finger, Property::Mode, kModeTrapezoid, false);
    again = true;
  }
  return again;
}

void HandMotion::verify(Timestamp now) {
  if (link_.busy()) return;
  if (!verify_timed_) {
    verify_timed_ = true;
    verify_until_ = now + std::chrono::nanoseconds(static_cast<std::int64_t>(1e9 * config_.verify_s));
  }
  if (now < verify_until_) return;
  if (press_tries_ < kTries && press_again()) {
    ++press_tries_;
    verify_timed_ = false;
    return;
  }
  bool any_measured = !facts_.has_strain && !facts_.has_tactile;
  for (const Puck finger : kFingerPucks) {
    bool& contact = contact_[index(finger)];
    // what gave way under the pressure was nothing
    if (position(finger) >= kClosedCounts - kNear) contact = false;
    any_measured = any_measured || (contact && measured(finger, now));
  }
  if (!opposed() || !any_measured) {
    if (opposed()) say(why_, "the fingers stopped, but neither strain gauges nor pads measure a force");
    give_up_grip();
    return;
  }
  for (const Puck finger : kFingerPucks) {
    const double kept_nm = hold_units_[index(finger)] / config_.torque_units_per_nm;
    const double strain = strain_above_idle(link_, facts_, finger);
    if (!contact_[index(finger)] || !pressing_ || !(strain < kHeldFraction * kept_nm)) continue;
    const double part = torque_fraction(link_, facts_, finger);
    if (part < 1.0)
      say(why_,
          "{} holds with {:.2f} of {:.2f} N m: at {} C its puck gives {:.0f} % of its torque, let it cool",
          name(finger), std::max(strain, 0.0), kept_nm, link_.reported(finger, Property::Temp).value,
          100.0 * part);
    else
      say(why_, "{} holds with {:.2f} of {:.2f} N m", name(finger), std::max(strain, 0.0), kept_nm);
    give_up_grip();
    return;
  }
  phase_ = Phase::Held;
  slip_.start();
}

void HandMotion::watch_grip(Timestamp now) {
  std::array<double, kFingers> inner{}, strain{}, pads{};
  Timestamp at = now;
  for (const Puck finger : kFingerPucks) {
    const std::size_t f = index(finger);
    const Reported& p = link_.reported(finger, Property::P);
    inner[f] = p.value / kFingerCounts_rad;
    strain[f] = strain_above_idle(link_, facts_, finger);
    pads[f] = pad_force(link_, facts_, finger, now);
    at = std::min(at, p.at);
    if (contact_[f] && !facts_.zero_lost[f] && p.value >= kClosedCounts - kNear) contact_[f] = false;
  }
  std::array<bool, kFingers> holding = contact_;
  for (std::size_t f = 0; f < kFingers; ++f) holding[f] = holding[f] && !facts_.zero_lost[f];
  const bool before = slip_.slipped();
  slip_.add(at, inner, strain, pads, holding);
  if (slip_.slipped() && !before) {
    say(why_, "the object slips in the hand");
    grip_up();
  }
  for (const Puck finger : kFingerPucks) {
    const std::size_t f = index(finger);
    // not so when the strain is not known
    if (rests_[f] && pressing_ && contact_[f] && strain[f] < kRelaxed_nm) press(finger);
  }
  if (!opposed()) {
    why_ = {};
    say(why_, "the grip is lost: the fingers closed through to their stops");
    give_up_grip();
  }
}

void HandMotion::limit_hold(double units) {
  if (units == hold_limit_units_) return;
  hold_limit_units_ = units;
  if (!pressing_) return;
  if (units <= 0.0) {
    pressing_ = false;
    for (const Puck finger : kFingerPucks) let_rest(finger);
    return;
  }
  for (const Puck finger : kFingerPucks) {
    double& most = hold_units_[index(finger)];
    most = std::min(most, units);
    if (contact_[index(finger)]) link_.set(finger, Property::Mt, static_cast<std::int32_t>(most), true);
  }
}

bool HandMotion::pressing(Puck finger, Timestamp now) const {
  return phase_ == Phase::Held && pressing_ && finger != Puck::Spread && contact_[index(finger)] &&
         !rests_[index(finger)] && position(finger) < kClosedCounts - kNear && !link_.busy(finger) &&
         now > link_.mode_set_at(finger) + kModeSettles;
}

}  // namespace colift::hal::barrett
