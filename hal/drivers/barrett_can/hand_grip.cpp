// The grip: from fingers that have stopped to one that is held, and watched.
#include <cmath>
#include <numbers>

#include "hal/drivers/barrett_can/hand_motion.hpp"
#include "hal/types/units.hpp"

namespace colift::hal::barrett {
namespace {

constexpr double kOneSide_rad = 2.6;  // of spread: all fingers press from one side, against the palm
constexpr double kOpposed_rad = std::numbers::pi / 3;  // of spread: up to here F1 and F2 press against F3
// Of the torque that a finger keeps up, measured at its gauge: less is no grip. The units per N m of a motor
// are known to a third.
constexpr double kHeldFraction = 0.4;
constexpr double kWarmMotor_c = 44.0;  // from where a puck gives less torque (its OTEMP of 60 less 16)
constexpr int kSpreadReadings = 2;     // in a row
// Of the time after which a puck ends its pressing: when it is renewed, and from when on it may have run out
// though the last renewal left (which nobody acknowledges).
constexpr double kRenewAfter = 0.3, kRanOutAfter = 0.5;
constexpr Duration kFresh = std::chrono::milliseconds(15);  // of a mode
constexpr double kRelaxed_nm = 0.5;  // a finger that its puck let off presses again below

}  // namespace

bool HandMotion::measured(Puck finger, Timestamp now) const {
  const GoodPosition& p = facts_.good[index(finger)];
  // comparisons with NaN are false
  return strain_above_idle(link_, facts_, finger) > config_.contact_nm ||
         pad_force(link_, facts_, finger, now) > config_.contact_n ||
         (p.known && broken_away(p.motor, p.joint));
}

// F3 bears what F1 and F2 press: no fingertip may get more than was wished, and no gauge more than it stands.
double HandMotion::share(Puck finger) const {
  const double spread_rad = position(Puck::Spread) / kSpreadCounts_rad;
  if (finger == Puck::F3 || spread_rad >= kOpposed_rad) return 1.0;
  return 0.5 / std::cos(spread_rad);
}

// The motor goes on pressing against what stopped it, for so long that it is renewed three times: a program
// that dies leaves no motor on, and the worm holds without it.
void HandMotion::press(Puck finger) {
  rests_[index(finger)] = false;
  link_.drop_settings(finger);
  link_.set(finger, Property::Mt, static_cast<std::int32_t>(hold_units_[index(finger)]), true);
  link_.set(finger, Property::Tstop, static_cast<std::int32_t>(config_.press_ms), true);
  if (facts_.has_strain) link_.set(finger, Property::Hsg, 0, true);
  link_.set(finger, Property::E, kClosedCounts, true);
  link_.set(finger, Property::Mode, kModeTrapezoid, false);
}

bool HandMotion::pressing_ran_out(Puck finger, Timestamp now) const {
  return 1e3 * seconds(now - link_.mode_set_at(finger)) > kRanOutAfter * config_.press_ms;
}

void HandMotion::renew_pressing(Timestamp now) {
  if (!pressing_ || facts_.commanded_by_others) return;
  for (const Puck finger : kFingerPucks) {
    const std::size_t f = index(finger);
    // a puck that counts from elsewhere may take the end of its move for behind it, and open
    if (!contact_[f] || rests_[f] || facts_.zero_lost[f] || facts_.mode_lost[f] || facts_.jump_pending[f])
      continue;
    if (link_.busy(finger) || link_.silent(finger) || link_.repeats(finger)) continue;
    const Timestamp set_at = link_.mode_set_at(finger);
    if (1e3 * seconds(now - set_at) < kRenewAfter * config_.press_ms) continue;
    const Reported& mode = link_.reported(finger, Property::Mode);
    if (!pressing_ran_out(finger, now)) {
      // one that ended its pressing because of something else is not healed unseen: the monitor judges it
      const bool fresh = mode.known && now - mode.asked_at <= kFresh + link_.round_trip().worst();
      if (!fresh) link_.ask(finger, Property::Mode);
      if (!fresh || mode.value != kModeTrapezoid) continue;
    }
    link_.set(finger, Property::Mode, kModeTrapezoid, false);
  }
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
        std::clamp(share(finger) * config_.max_torque_nm * facts_.units_per_nm[index(finger)],
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
  grip_failed_ = true;
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

// Why a finger presses with less than it was told, as far as its puck lets it be seen.
void HandMotion::say_weak(Puck finger, double holds_nm, double kept_nm) {
  const double part = torque_fraction(link_, facts_, finger);
  const Reported& therm = link_.reported(finger, Property::Therm);
  const Reported& current = link_.reported(finger, Property::Imotor);
  if (part < 1.0)
    say(why_,
        "{} holds with {:.2f} of {:.2f} N m: at {} C its puck gives {:.0f} % of its torque, let it cool",
        name(finger), holds_nm, kept_nm, link_.reported(finger, Property::Temp).value, 100.0 * part);
  else if (therm.known && therm.value >= kWarmMotor_c)
    say(why_, "{} holds with {:.2f} of {:.2f} N m: its motor has {} C, let it cool", name(finger), holds_nm,
        kept_nm, therm.value);
  else if (current.known && current.at > link_.mode_set_at(finger))
    say(why_, "{} holds with {:.2f} of {:.2f} N m; its motor draws {:.2f} A", name(finger), holds_nm, kept_nm,
        std::abs(motor_a(current.value)));
  else
    say(why_, "{} holds with {:.2f} of {:.2f} N m", name(finger), holds_nm, kept_nm);
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
    const double kept_nm = hold_units_[index(finger)] / facts_.units_per_nm[index(finger)];
    const double strain = strain_above_idle(link_, facts_, finger);
    if (!contact_[index(finger)] || !pressing_ || !(strain < kHeldFraction * kept_nm)) continue;
    say_weak(finger, std::max(strain, 0.0), kept_nm);
    give_up_grip();
    return;
  }
  phase_ = Phase::Held;
  slip_.start();
  pattern_.start();
  spread_turned_ = false;
}

// The only joint without a worm gear: a load that is heavier than its motor turns it, with closed fingers.
void HandMotion::watch_spread() {
  const GoodPosition& spread = facts_.good[index(Puck::Spread)];
  if (!loaded_ || moving() || !spread.known) return;
  if (facts_.zero_lost[index(Puck::Spread)] || facts_.jump_pending[index(Puck::Spread)]) return;
  if (!spread_kept_) spread_kept_ = spread.motor;
  if (spread.at <= spread_seen_ || spread_turned_) return;
  spread_seen_ = spread.at;
  const double turned_rad = (spread.motor - *spread_kept_) / kSpreadCounts_rad;
  spread_off_ = std::abs(turned_rad) > config_.spread_slip_rad ? spread_off_ + 1 : 0;
  if (spread_off_ < kSpreadReadings) return;
  spread_turned_ = true;
  say(why_, "the spread turned by {:.0f} degrees under load (limit {:.0f}): what is held may fall",
      rad_to_deg(turned_rad), rad_to_deg(config_.spread_slip_rad));
}

void HandMotion::watch_grip(Timestamp now) {
  std::array<double, kFingers> inner{}, strain{}, pads{};
  Timestamp at = now;
  for (const Puck finger : kFingerPucks) {
    const std::size_t f = index(finger);
    // a jump is reported as a jump, not as fingers that close: once it has been judged
    if (contact_[f] && facts_.jump_pending[f]) return;
    inner[f] = position(finger) / kFingerCounts_rad;
    strain[f] = strain_above_idle(link_, facts_, finger);
    pads[f] = pad_force(link_, facts_, finger, now);
    at = std::min(at, link_.reported(finger, Property::P).at);
    if (contact_[f] && !facts_.zero_lost[f] && position(finger) >= kClosedCounts - kNear) contact_[f] = false;
  }
  std::array<bool, kFingers> holding = contact_;
  for (std::size_t f = 0; f < kFingers; ++f) holding[f] = holding[f] && !facts_.zero_lost[f];
  const bool before = slip_.slipped() || pattern_.slipped();
  slip_.add(at, inner, strain, pads, holding);
  std::array<TactileArray, kFingers> cells;
  for (const Puck finger : kFingerPucks) cells[index(finger)] = pad_cells(link_, facts_, finger, now);
  pattern_.add(cells, holding);
  if ((slip_.slipped() || pattern_.slipped()) && !before) {
    say(why_, "{}",
        slip_.slipped() ? "the object slips in the hand"
                        : "the object slips: its pattern moves over the pads");
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
