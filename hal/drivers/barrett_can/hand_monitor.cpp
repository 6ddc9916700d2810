#include "hal/drivers/barrett_can/hand_monitor.hpp"

#include <cstdlib>
#include <utility>

namespace colift::hal::barrett {
namespace {

constexpr double kMost_counts_ms = 400.0;  // twice what a motor does
constexpr std::int32_t kJump = 2500;
constexpr int kJumpsAbout = 5;     // in a row, each time to another place
constexpr double kCooled_c = 3.0;  // below a limit before it counts as left
constexpr int kTorquesOver = 3;    // readings in a row
// Below 18 V a puck resets and loses its zero; the maker's supply gives 48 V.
constexpr std::int32_t kLowSupply_v = 24, kMostSupply_v = 100;
constexpr int kSupplyLow = 2;  // readings in a row
// What changes slowly is asked in turn.
constexpr std::array kSlow{Property::Temp, Property::Therm, Property::Temp, Property::Therm, Property::Vbus};
// a puck lets off by itself above 3460; between two readings the strain may have been higher
constexpr std::int32_t kStrainedFrom = kStrainMost - 100;
constexpr Duration kStrainedFor = std::chrono::milliseconds(300);

Duration ms(double value) {
  return std::chrono::nanoseconds(static_cast<std::int64_t>(1e6 * value));
}

}  // namespace

HandMonitor::HandMonitor(const BarrettHandConfig& config, PuckLink& link, BusMonitor& bus, HandFacts& facts,
                         HandMotion& motion)
    : config_(config), link_(link), bus_(bus), facts_(facts), motion_(motion), others_(link, facts) {
  measure_.period = ms(config.measure_ms);
  status_.period = ms(config.status_ms);
  mode_.period = ms(2.0 * config.measure_ms);
  pads_.period = ms(config.tactile_ms);
  palm_.period = ms(5.0 * config.tactile_ms);
  heat_.period = ms(0.4 * config.temperature_ms);  // puck, motor and supply in turn
  torque_.period = ms(50.0);                       // torque and current in turn
  ping_.period = ms(100.0);
}

void HandMonitor::start() {
  facts_.good = {};
  facts_.jump_pending = {};
  facts_.commanded_by_others = false;
  others_.start();
  jumps_ = {};
  jumped_to_ = {};
  judged_at_ = mode_suspected_ = reset_suspected_ = mark_suspected_ = {};
  torques_over_ = {};
  strained_at_ = {};
  was_quiet_ = failed_ = without_ = {};
  warm_ = hot_ = fades_ = over_torque_ = spread_kept_on_ = false;
  warning_ = outage_ = supply_ = {};
  supply_low_ = 0;
  supply_seen_ = {};
}

void HandMonitor::ask(Timestamp now) {
  if (measure_.due(now)) {
    link_.ask_all(Property::P);
    if (facts_.has_strain)
      for (const Puck finger : kFingerPucks)
        if (!link_.silent(finger)) link_.ask(finger, Property::Sg);
  }
  if (status_.due(now)) {
    link_.ask_all(Property::Stat);
    for (const Puck puck : kAllPucks) {
      if (!link_.silent(puck)) continue;
      link_.ask(puck, Property::Stat);
      link_.ask_lost(puck);
    }
    if (!motion_.moving()) link_.ask_all(Property::Mode);
    others_.ask();
  }
  if (ping_.due(now)) link_.ping();
  if (motion_.moving() && mode_.due(now)) link_.ask_all(Property::Mode);
  if (pads_.due(now))
    for (const Puck finger : kFingerPucks)
      if (facts_.pad_works[index(finger)] && !link_.silent(finger))
        link_.ask_tactile(finger, facts_.tactile_format);
  if (palm_.due(now) && facts_.pad_works[index(Puck::Spread)] && !link_.silent(Puck::Spread))
    link_.ask_tactile(Puck::Spread, facts_.tactile_format);
  if (heat_.due(now)) {
    link_.ask_all(kSlow[static_cast<std::size_t>(slow_turn_)]);
    slow_turn_ = (slow_turn_ + 1) % static_cast<int>(kSlow.size());
  }
  if ((motion_.moving() || motion_.loaded()) && torque_.due(now)) {
    link_.ask_all(current_next_ ? Property::Imotor : Property::T);
    current_next_ = !current_next_;
  }
}

void HandMonitor::lose_zero(Puck puck) {
  if (facts_.zero_lost[index(puck)]) return;
  facts_.zero_lost[index(puck)] = true;
  link_.drop_settings(puck);
  motion_.stop();  // the others stay where they are; a grip is kept
}

// A reset puck has its factory's CT back; one that still has our mark counts from somewhere else, and its
// mark is taken away, so that no program after this one believes it.
void HandMonitor::lose_zero_by_jump(Puck puck, std::int32_t by) {
  if (facts_.zero_lost[index(puck)]) return;
  const Reported &stat = link_.reported(puck, Property::Stat), &ct = link_.reported(puck, Property::Ct);
  const bool asleep = stat.known && stat.value == kStatReset;
  const bool woken = ct.known && ct.asked_at > facts_.good[index(puck)].at && ct.value == factory_ct(puck);
  lose_zero(puck);
  if (asleep || woken) return;
  facts_.jumped_by[index(puck)] = by;
  motion_.stay_without_zero(puck);
  link_.set(puck, Property::Ct, factory_ct(puck), false);
}

void HandMonitor::judge_position(Puck puck) {
  const Reported& p = link_.reported(puck, Property::P);
  GoodPosition& good = facts_.good[index(puck)];
  if (!p.known || p.at <= judged_at_[index(puck)]) return;
  judged_at_[index(puck)] = p.at;
  const Reported& joint = link_.reported(puck, Property::Jp);
  const double reach = kJump + kMost_counts_ms * 1e3 * seconds(p.at - good.at);
  if (good.known && std::abs(p.value - good.motor) > reach) {
    // once may be a bad frame; twice at one place, the encoder counts from somewhere else
    link_.ask(puck, Property::Stat);
    link_.ask(puck, Property::Ct);
    facts_.jump_pending[index(puck)] = true;
    std::int32_t& there = jumped_to_[index(puck)];
    const bool again = jumps_[index(puck)] > 0 && std::abs(p.value - there) <= reach;
    there = p.value;
    if (++jumps_[index(puck)] < (again ? 2 : kJumpsAbout)) return;
    lose_zero_by_jump(puck, p.value - good.motor);
  }
  jumps_[index(puck)] = 0;
  facts_.jump_pending[index(puck)] = false;
  good = {p.value, joint.known ? std::optional(joint.value) : std::nullopt, p.at, true};
}

void HandMonitor::judge_status(Puck puck) {
  const Reported& stat = link_.reported(puck, Property::Stat);
  // silent, or only reset? Then it answers this alone; asked before it counts as silent, so that it is told
  // right
  const bool quiet = link_.silent(puck) || link_.repeats(puck);
  if (quiet && !was_quiet_[index(puck)]) link_.ask(puck, Property::Stat);
  was_quiet_[index(puck)] = quiet;
  if (!stat.known) return;
  Timestamp& suspected = reset_suspected_[index(puck)];
  if (stat.value != kStatReset) {
    suspected = Timestamp{0};
  } else if (suspected == Timestamp{0}) {
    suspected = stat.at;  // once more, before anybody stops for it
    link_.ask(puck, Property::Stat);
  } else if (stat.at > suspected) {
    facts_.jumped_by[index(puck)] = 0;
    lose_zero(puck);
  }
  // it is told with its code, for which three questions are waited at most
  const bool in_error = stat.value == kStatError;
  const bool code_asked =
      link_.reported(puck, Property::Error).known || link_.unanswered(puck, Property::Error);
  if (in_error && !code_asked) link_.ask(puck, Property::Error);
  failed_[index(puck)] = in_error && code_asked;
}

// A puck that was reset and woken by somebody else between two looks has its factory's CT back.
void HandMonitor::judge_mark(Puck puck) {
  const Reported& ct = link_.reported(puck, Property::Ct);
  Timestamp& suspected = mark_suspected_[index(puck)];
  if (!ct.known || ct.value != factory_ct(puck) || facts_.zero_lost[index(puck)]) {
    suspected = Timestamp{0};
  } else if (suspected == Timestamp{0}) {
    suspected = ct.at;
    link_.ask(puck, Property::Ct);
  } else if (ct.at > suspected) {
    facts_.jumped_by[index(puck)] = 0;
    lose_zero(puck);
  }
}

void HandMonitor::judge_mode(Puck puck, Timestamp now) {
  const Reported& mode = link_.reported(puck, Property::Mode);
  Timestamp& suspected = mode_suspected_[index(puck)];
  if (puck != Puck::Spread && facts_.has_strain)
    if (const Reported& sg = link_.reported(puck, Property::Sg); sg.known && sg.value >= kStrainedFrom)
      strained_at_[index(puck)] = sg.at;
  const bool keeps = puck == Puck::Spread
                         ? motion_.keeps_spread() && spread_kept_on_
                         : motion_.pressing(puck, now) && !motion_.pressing_ran_out(puck, now);
  if (puck == Puck::Spread)  // by whatever mode; a hand that was found closed may have it off from the start
    spread_kept_on_ = motion_.keeps_spread() && (spread_kept_on_ || (mode.known && mode.value != kModeIdle));
  if (!keeps || !mode.known || mode.asked_at <= link_.mode_set_at(puck)) return;
  if (puck == Puck::Spread ? mode.value != kModeIdle : mode.value == kModeTrapezoid) {
    suspected = Timestamp{0};
  } else if (suspected == Timestamp{0}) {
    suspected = mode.at;  // once more, before anybody stops for it
    link_.ask(puck, Property::Mode);
  } else if (mode.at > suspected) {
    suspected = Timestamp{0};
    if (puck != Puck::Spread && strained_at_[index(puck)] > Timestamp{0} &&
        now - strained_at_[index(puck)] < kStrainedFor)
      motion_.rest(puck);
    else
      facts_.mode_lost[index(puck)] = true;
  }
}

double HandMonitor::temperature_c(Puck puck) const {
  double hottest = std::numeric_limits<double>::quiet_NaN();
  for (const Property p : {Property::Temp, Property::Therm})
    if (const Reported& t = link_.reported(puck, p); t.known) hottest = std::fmax(hottest, t.value);
  return hottest;
}

double HandMonitor::hottest_c() const {
  double hottest = std::numeric_limits<double>::quiet_NaN();
  for (const Puck puck : kAllPucks) hottest = std::fmax(hottest, temperature_c(puck));
  return hottest;
}

void HandMonitor::judge_heat() {
  const double now_c = hottest_c();
  if (std::isnan(now_c)) return;
  const bool was_warm = warm_, was_hot = hot_;
  hot_ = now_c >= config_.limit_c - (hot_ ? kCooled_c : 0.0);
  warm_ = hot_ || now_c >= config_.warn_c - (warm_ ? kCooled_c : 0.0);
  // before the force fades, and long before the maker's limit: its pucks give less torque from OTEMP - 16 on
  double part = 1.0;
  for (const Puck finger : kFingerPucks) part = std::min(part, torque_fraction(link_, facts_, finger));
  const bool faded = std::exchange(fades_, part < 1.0);
  if (hot_ == was_hot && warm_ == was_warm && fades_ == faded) return;
  if (hot_)
    say(warning_, "the hand has {:.0f} C (limit {:.0f}): {}", now_c, config_.limit_c,
        motion_.loaded() ? "lower the object; the worms alone hold it"
                         : "it closes no more until it has cooled");
  else if (warm_)
    say(warning_, "the hand has {:.0f} C (warning from {:.0f}): it holds with less torque", now_c,
        config_.warn_c);
  else if (fades_)
    say(warning_,
        "the hand has {:.0f} C: its pucks give {:.0f} % of their torque, and less as it gets warmer", now_c,
        100.0 * part);
  else
    warning_ = {};
  if (!over_torque_)
    motion_.limit_hold(hot_ ? 0.0 : warm_ ? config_.warm_hold_torque_units : config_.hold_torque_units);
}

// A supply that sags says so before the pucks reset. What no supply can give is a bad frame or no answer at
// all.
void HandMonitor::judge_supply() {
  std::int32_t least_v = kMostSupply_v;
  bool news = false;
  for (const Puck puck : kAllPucks) {
    const Reported& v = link_.reported(puck, Property::Vbus);
    if (!v.known || v.value <= 0 || v.value > kMostSupply_v) continue;
    least_v = std::min(least_v, v.value);
    news = news || v.at > supply_seen_[index(puck)];
    supply_seen_[index(puck)] = v.at;
  }
  if (!news) return;
  supply_low_ = least_v < kLowSupply_v ? supply_low_ + 1 : 0;
  if (supply_low_ == 0) supply_ = {};
  if (supply_low_ >= kSupplyLow)
    say(supply_, "the hand's supply gives {} V of 48: below 18 V its pucks reset and lose their zero",
        least_v);
}

void HandMonitor::judge_torque(Puck puck) {
  const Reported &t = link_.reported(puck, Property::T), &limit = link_.reported(puck, Property::Mt);
  if (!t.known || !limit.known || t.at <= torque_seen_[index(puck)]) return;
  torque_seen_[index(puck)] = t.at;
  int& over = torques_over_[index(puck)];
  over = std::abs(t.value) > limit.value + limit.value / 4 + 100 ? over + 1 : 0;
  if (over < kTorquesOver || over_torque_) return;
  over_torque_ = true;
  say(warning_, "{} gives {} units of torque, {} were allowed: its worm alone holds", name(puck), t.value,
      limit.value);
  motion_.limit_hold(0.0);
}

void HandMonitor::step(Timestamp now) {
  const auto before = bus_.state();
  bus_.step(now);
  if (before == BusMonitor::State::Up && bus_.state() != before) {
    motion_.abandon();
    lost_at_ = now;
  }
  if (before != BusMonitor::State::Up && bus_.state() == BusMonitor::State::Up && motion_.loaded())
    say(outage_,
        "the connection to the bus was lost for {:.1f} s while the hand was closed: its worms alone held",
        seconds(now - lost_at_));
  if (bus_.state() == BusMonitor::State::Up) ask(now);
  for (const Puck puck : kAllPucks) {
    judge_status(puck);
    judge_position(puck);
    judge_mark(puck);
    judge_mode(puck, now);
    judge_torque(puck);
    // it is back when its position is as fresh as those of the others
    const bool fresh = seconds(now - facts_.good[index(puck)].at) < 0.5 * config_.stale_s;
    if (!link_.silent(puck) && fresh) without_[index(puck)] = false;
  }
  judge_heat();
  judge_supply();
  others_.step(now);
  if (!others_.commands() || facts_.commanded_by_others) return;
  facts_.commanded_by_others = true;
  motion_.stop();  // a grip is kept
}

void HandMonitor::go_without_silent() {
  const auto silent = [&](Puck p) { return link_.silent(p); };
  if (std::all_of(kAllPucks.begin(), kAllPucks.end(), silent)) return;  // then there is nobody to go on with
  for (const Puck puck : kAllPucks) without_[index(puck)] = without_[index(puck)] || link_.silent(puck);
}

std::optional<Puck> HandMonitor::missing() const {
  for (const Puck puck : kAllPucks)
    if (without_[index(puck)]) return puck;
  return std::nullopt;
}

bool HandMonitor::all_known() const {
  return std::all_of(facts_.good.begin(), facts_.good.end(), [](const GoodPosition& p) { return p.known; });
}

Timestamp HandMonitor::oldest_position() const {
  Timestamp oldest = Timestamp::max();
  for (const Puck puck : kAllPucks)
    if (!without_[index(puck)]) oldest = std::min(oldest, facts_.good[index(puck)].at);
  return oldest == Timestamp::max() ? Timestamp{0} : oldest;  // without any of them: no state
}

std::optional<HandFault> HandMonitor::fault() const {
  HandFault t;
  if (bus_.state() == BusMonitor::State::Lost) {
    t.words = bus_.why();
    return t;
  }
  if (bus_.state() == BusMonitor::State::Asking) {
    say(t.words, "bus-off or down until now: the pucks are asked for their state");
    return t;
  }
  const char* held = motion_.loaded() ? " while the hand is loaded: support the object, then release"
                                      : ": it has to be initialised anew";
  for (const Puck puck : kAllPucks) {
    if (failed_[index(puck)]) {
      t.code = ErrorCode::DeviceFault;
      const Reported& error = link_.reported(puck, Property::Error);
      say(t.words, "{} reports an error (code {})", name(puck), error.known ? error.value : -1);
      return t;
    }
    if (facts_.zero_lost[index(puck)]) {
      t.code = ErrorCode::DeviceFault;
      if (const std::int32_t by = facts_.jumped_by[index(puck)]; by != 0)
        say(t.words, "the encoder of {} jumped by {} counts without a reset: it has lost its zero{}",
            name(puck), by, held);
      else
        say(t.words, "{} was reset and has lost its zero{}", name(puck), held);
      return t;
    }
  }
  if (others_.commands()) {
    t.code = ErrorCode::DeviceFault;
    t.words = others_.words();
    return t;
  }
  const auto silent =
      std::count_if(kAllPucks.begin(), kAllPucks.end(), [&](Puck p) { return link_.silent(p); });
  for (const Puck puck : kAllPucks) {
    if (!link_.silent(puck) || without_[index(puck)]) continue;
    if (silent == static_cast<std::ptrdiff_t>(kPucks)) {
      say(t.words,
          "all four pucks are silent: the bus may be off (bus-off, which not every gateway reports), or the "
          "supply, or the cable is out");
      return t;
    }
    if (silent == 1) t.alone = puck;
    say(t.words, "{} (node {}) is silent: three questions without an answer", name(puck), node_id(puck));
    return t;
  }
  for (const Puck puck : kAllPucks) {
    if (!facts_.mode_lost[index(puck)]) continue;
    t.code = ErrorCode::DeviceFault;
    if (puck == Puck::Spread)
      say(t.words, "the spread has fallen out of its mode and nothing keeps its angle: support the object");
    else
      say(t.words, "{} has fallen out of its mode and presses no more; its worm holds", name(puck));
    return t;
  }
  return std::nullopt;
}

}  // namespace colift::hal::barrett
