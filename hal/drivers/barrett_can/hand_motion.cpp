#include "hal/drivers/barrett_can/hand_motion.hpp"

#include <cstdlib>

namespace colift::hal::barrett {
namespace {

constexpr std::int32_t kOpen = 4000;  // 3 degrees: nothing is in the spread's way
constexpr std::int32_t kHardlyMoved = 1000;
constexpr std::int32_t kLongPath = 3000;
constexpr std::int32_t kNoise = 50;
constexpr std::int32_t kSpreadNear = 60;

}  // namespace

HandMotion::HandMotion(const BarrettHandConfig& config, PuckLink& link, HandFacts& facts)
    : config_(config),
      link_(link),
      facts_(facts),
      hold_limit_units_(config.hold_torque_units),
      slip_({config.slip_rad, config.slip_share, config.contact_nm, config.contact_n}),
      pattern_({.moved_mm = config.slip_pattern_mm}) {}

bool HandMotion::any_active() const {
  return std::any_of(moves_.begin(), moves_.end(), [](const Move& m) { return m.active; });
}

void HandMotion::begin(Puck puck, std::int32_t target, double torque_units, int strain_limit) {
  link_.drop_settings(puck);
  (void)link_.take_refusal(puck);
  facts_.mode_lost[index(puck)] = false;
  // a motor that still presses would do so with the new torque, and towards the old end, until MODE comes
  if (puck != Puck::Spread || moves_[index(puck)].active) link_.set(puck, Property::Mode, kModeIdle, true);
  link_.set(puck, Property::Mt, static_cast<std::int32_t>(torque_units), true);
  link_.set(puck, Property::Tstop, static_cast<std::int32_t>(config_.stopped_ms), true);
  if (facts_.has_strain && puck != Puck::Spread) link_.set(puck, Property::Hsg, strain_limit, true);
  link_.set(puck, Property::E, target, true);
  link_.set(puck, Property::Mode, kModeTrapezoid, false);
  Move& move = moves_[index(puck)];
  move = {};
  move.active = true;
  move.start = move.last = position(puck);
  move.target = target;
}

void HandMotion::let_rest(Puck puck) {
  link_.drop_settings(puck);
  link_.set(puck, Property::Mode, kModeIdle, false);
  moves_[index(puck)].active = false;
}

void HandMotion::open_fingers() {
  pressing_ = false;
  contact_ = rests_ = {};
  spread_kept_.reset();
  facts_.mode_lost = {};
  for (const Puck finger : kFingerPucks) {
    moves_[index(finger)].active = false;
    if (facts_.zero_lost[index(finger)]) {
      // its "0" is where it stands now
      let_rest(finger);
      say(why_, "{} has lost its zero and was not opened: it has to be initialised anew", name(finger));
    } else if (std::abs(position(finger)) > kNear / 2) {
      begin(finger, 0, config_.move_torque_units, 0);
    } else {
      let_rest(finger);
    }
  }
  phase_ = Phase::Opening;
}

void HandMotion::preshape(double spread_rad) {
  why_ = {};
  grip_failed_ = false;
  spread_target_ = spread_counts(spread_rad);
  turn_after_ = true;
  releasing_ = false;
  open_fingers();
}

void HandMotion::release() {
  why_ = {};
  grip_failed_ = false;
  turn_after_ = false;
  releasing_ = true;
  slip_.start();
  pattern_.start();
  spread_turned_ = false;
  open_fingers();
}

void HandMotion::close(double torque_nm) {
  why_ = {};
  grip_failed_ = false;
  torque_nm_ = torque_nm;
  pressing_ = false;
  rests_ = {};
  spread_kept_.reset();
  spread_turned_ = false;
  for (const Puck finger : kFingerPucks)
    if (moves_[index(finger)].active) let_rest(finger);
  phase_ = Phase::Closing;
  // closed fingers would meet the turning ones
  waiting_ = moves_[index(Puck::Spread)].active;
  if (!waiting_) begin_closing();
}

void HandMotion::begin_closing() {
  waiting_ = false;
  gripped_up_ = false;
  for (const Puck finger : kFingerPucks) {
    const double torque_nm = share(finger) * torque_nm_;
    const double units = std::clamp(torque_nm * facts_.units_per_nm[index(finger)], config_.min_torque_units,
                                    config_.move_torque_units);
    hold_units_[index(finger)] = std::min(units, hold_limit_units_);
    const bool by_strain = facts_.has_strain && config_.stop_on_strain;
    begin(finger, kClosedCounts, units, by_strain ? strain_limit(facts_, finger, torque_nm) : 0);
  }
}

void HandMotion::stop() {
  switch (phase_) {
    case Phase::Still:
    case Phase::Held:
    case Phase::Verifying:  // they do not go anywhere, and the grip is kept
      return;
    case Phase::Opening:
    case Phase::Closing:
      for (const Puck finger : kFingerPucks) {
        if (phase_ == Phase::Closing && moves_[index(finger)].end == End::Stalled)
          contact_[index(finger)] = true;
        let_rest(finger);
      }
      break;
    case Phase::Turning:
      break;
  }
  if (moves_[index(Puck::Spread)].active) {
    // the spread has no worm: it is told to stay and keeps its mode of holding
    let_rest(Puck::Spread);
    link_.set(Puck::Spread, Property::E, position(Puck::Spread), true);
    link_.set(Puck::Spread, Property::Mode, kModeTrapezoid, false);
  }
  phase_ = Phase::Still;
}

void HandMotion::stay_without_zero(Puck puck) {
  if (puck == Puck::Spread && loaded_) {
    link_.set(puck, Property::E, link_.reported(puck, Property::P).value, true);
    return;
  }
  link_.set(puck, Property::Mode, kModeIdle, true);
  moves_[index(puck)].active = false;
}

void HandMotion::idle() {
  stop();
  pressing_ = false;
  for (const Puck puck : kAllPucks) {
    if (puck == Puck::Spread && loaded_) continue;  // it has no worm
    link_.drop_settings(puck);
    link_.set(puck, Property::Mode, kModeIdle, true);
    moves_[index(puck)].active = false;
  }
  if (phase_ == Phase::Verifying) phase_ = Phase::Still;
}

void HandMotion::resume() {
  if (phase_ == Phase::Held && !pressing_ && hold_limit_units_ > 0.0) press();
}

void HandMotion::abandon() {
  link_.drop_all();
  for (Move& move : moves_) move.active = false;
  if (phase_ == Phase::Closing || phase_ == Phase::Verifying) {
    loaded_ = true;  // nobody knows what they have met by now
    why_ = {};
    say(why_, "the bus was lost while the fingers closed: not known what they hold");
  }
  if (phase_ != Phase::Held) phase_ = Phase::Still;
}

std::optional<HandMotion::End> HandMotion::how_it_ended(Puck puck, const Move& move, Timestamp now) const {
  const auto by_position = [&] {
    const std::int32_t p = position(puck);
    if (std::abs(p - move.target) <= kNear) return End::Reached;
    const bool stood =
        std::abs(p - move.start) < kHardlyMoved && std::abs(move.target - move.start) > kLongPath;
    return stood ? End::NoMotion : End::Stalled;
  };
  if (link_.silent(puck)) return End::Silent;
  if (facts_.jump_pending[index(puck)]) return std::nullopt;
  const Reported& mode = link_.reported(puck, Property::Mode);
  const Timestamp set_at = link_.mode_set_at(puck);
  // asked sooner, the answer may be of before: copies on the bus come late
  if (mode.known && mode.asked_at > set_at + kModeSettles &&
      (mode.value == kModeIdle || mode.value == kModePid) &&
      link_.reported(puck, Property::P).asked_at >= mode.asked_at)
    return by_position();
  const Duration still = std::chrono::nanoseconds(static_cast<std::int64_t>(1e9 * config_.still_s));
  if (now - move.moved_at > still) return by_position();
  if (seconds(now - move.started_at) > config_.move_s) return End::TooLong;
  return std::nullopt;
}

// Idle before TSTOP can have ended the move: the setting of MODE, which nobody acknowledges, did not arrive.
bool HandMotion::said_too_early(Puck puck) const {
  const Reported& mode = link_.reported(puck, Property::Mode);
  return mode.value != kModeTrapezoid &&
         seconds(mode.at - link_.mode_set_at(puck)) < 0.8e-3 * config_.stopped_ms;
}

void HandMotion::step_move(Puck puck, Timestamp now) {
  Move& move = moves_[index(puck)];
  if (!move.active) return;
  if (const auto refused = link_.take_refusal(puck)) {
    move.active = false;
    move.end = link_.silent(puck) ? End::Silent : End::Refused;
    say(why_, "{} did not take {}", name(puck), property_info(*refused).name);
    return;
  }
  if (link_.busy(puck)) return;
  if (!move.started) {
    move.started = true;
    move.started_at = move.moved_at = now;
  }
  if (std::abs(position(puck) - move.last) > kNoise) {
    move.last = position(puck);
    move.moved_at = now;
  }
  const auto end = how_it_ended(puck, move, now);
  if (!end) return;
  if (*end == End::NoMotion && said_too_early(puck) && move.tries < kTries) {
    ++move.tries;
    move.started = false;
    link_.set(puck, Property::Mode, kModeTrapezoid, false);
    return;
  }
  move.active = false;
  move.end = *end;
  const Reported& mode = link_.reported(puck, Property::Mode);
  if (*end == End::Silent) {
    say(why_, "{} stopped answering during the motion", name(puck));
    return;
  }
  if (mode.value == kModeTrapezoid) let_rest(puck);  // it pushes in vain, and nothing ends it
  if (*end == End::NoMotion)
    say(why_, "{} does not move (it stands at {:.2f} rad)", name(puck), position(puck) / kFingerCounts_rad);
  if (*end == End::TooLong) say(why_, "{} did not arrive within {:.0f} s", name(puck), config_.move_s);
}

void HandMotion::step(Timestamp now) {
  if (pressing_)
    for (const Puck finger : kFingerPucks)
      if (const auto refused = link_.take_refusal(finger))
        say(why_, "{} did not take {}: its worm alone holds", name(finger), property_info(*refused).name);
  for (const Puck puck : kAllPucks) step_move(puck, now);
  watch_spread();
  renew_pressing(now);
  switch (phase_) {
    case Phase::Still:
      break;
    case Phase::Opening:
      if (!any_active() && !link_.busy()) after_opening();
      break;
    case Phase::Turning:
      if (!any_active()) phase_ = Phase::Still;
      break;
    case Phase::Closing:
      if (waiting_) {
        if (!moves_[index(Puck::Spread)].active) begin_closing();
        break;
      }
      for (const Puck finger : kFingerPucks) {
        const Move& move = moves_[index(finger)];
        if (!move.active && move.end == End::Stalled) loaded_ = true;
      }
      if (!any_active()) after_closing(now);
      break;
    case Phase::Verifying:
      verify(now);
      break;
    case Phase::Held:
      watch_grip(now);
      break;
  }
}

void HandMotion::after_opening() {
  phase_ = Phase::Still;
  if (releasing_) loaded_ = false;
  releasing_ = false;
  const Puck* shut = nullptr;
  for (const Puck& finger : kFingerPucks)
    if (std::abs(position(finger)) > kOpen) shut = &finger;
  if (shut != nullptr && why_.empty())
    say(why_, "{} did not open: it stands at {:.2f} rad", name(*shut), position(*shut) / kFingerCounts_rad);
  for (const Puck finger : kFingerPucks) {
    const GoodPosition& p = facts_.good[index(finger)];
    if (shut == nullptr && why_.empty() && p.known && broken_away(p.motor, p.joint))
      say(why_,
          "{} is still broken away after opening: its outer link is ahead; it has to be initialised anew",
          name(finger));
  }
  if (!turn_after_) return;
  turn_after_ = false;
  if (shut != nullptr || facts_.zero_lost[index(Puck::Spread)]) return;  // it would be in the spread's way
  if (std::abs(position(Puck::Spread) - spread_target_) <= kSpreadNear) return;
  begin(Puck::Spread, spread_target_, config_.move_torque_units, 0);
  phase_ = Phase::Turning;
}

}  // namespace colift::hal::barrett
