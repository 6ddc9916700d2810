#include "hal/drivers/barrett_can/barrett_hand.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <numbers>
#include <string>

#include "hal/drivers/barrett_can/hand_monitor.hpp"
#include "hal/drivers/barrett_can/hand_motion.hpp"
#include "hal/drivers/barrett_can/hand_startup.hpp"
#include "hal/drivers/barrett_can/pucks/bus_monitor.hpp"
#include "hal/types/latest_value.hpp"

namespace colift::hal {

using namespace barrett;
using State = DeviceHealth::State;

namespace {

/// `where` of an error of state(): of one puck alone, or of the hand. Short enough not to be allocated.
constexpr std::array<const char*, 4> kWhereAlone{"hand.f1.state", "hand.f2.state", "hand.f3.state",
                                                 "hand.spread"};
const char* where_of(const HandFault& fault) {
  return fault.alone ? kWhereAlone[index(*fault.alone)] : "hand.state";
}

constexpr Duration kGap = std::chrono::milliseconds(30);  // nobody let the hand run
constexpr Duration kToRest = std::chrono::milliseconds(75), kReadBack = std::chrono::milliseconds(25);
constexpr Duration kCatchUp = std::chrono::milliseconds(3);

Duration from_seconds(double s) {
  return std::chrono::nanoseconds(static_cast<std::int64_t>(1e9 * s));
}

}  // namespace

struct BarrettHand::Impl {
  enum class Life { Absent, Configured, Active, Failed };

  struct Facts {
    State state = State::Absent;
    std::uint64_t accepted = 0, rejected = 0;
    ShortText last_error;
  };

  Impl(CanBus& the_bus, const BarrettHandConfig& the_config, const Clock& the_clock)
      : bus(the_bus),
        config(the_config),
        clock(the_clock),
        link(bus, clock, from_seconds(1e-3 * config.reply_ms), from_seconds(1e-3 * config.tactile_reply_ms)),
        motion(config, link, facts),
        bus_monitor(bus, link, from_seconds(config.reopen_s)),
        watch(config, link, bus_monitor, facts, motion) {}

  CanBus& bus;
  BarrettHandConfig config;
  const Clock& clock;
  PuckLink link;
  HandFacts facts;
  HandMotion motion;
  BusMonitor bus_monitor;
  HandMonitor watch;
  Life life = Life::Absent;
  std::atomic<bool> stop_wished{false};
  Timestamp polled_at{0};
  ShortText last_error, bus_words, remark;
  std::array<std::optional<std::int32_t>, kPucks> mode_at_rest{};
  LatestValue<Facts> latest_health;
  LatestValue<HandReport> latest_report;

  tl::unexpected<Error> fail(ErrorCode code, const char* where, std::string detail) {
    last_error.set(detail);
    publish();
    return failure(code, where, std::move(detail));
  }

  void poll(Duration timeout) {
    link.pump(timeout);
    const Timestamp now = clock.now();
    watch.step(now);
    if (stop_wished.exchange(false)) motion.stop();
    if (bus_monitor.state() == BusMonitor::State::Up) motion.step(now);
    link.pump(Duration::zero());  // what was decided goes out in the same turn
    polled_at = now;
  }

  void publish() {
    Facts f;
    switch (life) {
      case Life::Absent:
        f.state = State::Absent;
        break;
      case Life::Failed:
        f.state = State::Failed;
        break;
      case Life::Configured:
      case Life::Active:
        f.state = life == Life::Active ? State::Streaming : State::Opening;
        if (const auto fault = watch.fault())
          f.state = fault->code == ErrorCode::LinkLost ? State::Lost : State::Failed;
        else if (stale())
          f.state = State::Stalled;
        break;
    }
    const CanHealth can = bus.health();
    f.accepted = link.accepted();
    f.rejected = link.rejected() + can.dropped;
    f.last_error = last_error;
    if (can.state == CanHealth::State::Warning || can.state == CanHealth::State::Passive)
      say(bus_words, "the bus is error {} ({} error frames): go slower, look at cable and termination",
          can.state == CanHealth::State::Warning ? "warning" : "passive", can.error_frames);
    else if (link.round_trip().slow())
      say(bus_words, "slow link: the pucks answer after {:.1f} ms (expected within {:g}), faults show later",
          link.round_trip().worst_ms(), config.reply_ms);
    else
      bus_words = {};
    const std::array<const ShortText*, 4> lesser{&watch.warning(), &bus_words, &motion.why(), &remark};
    for (const ShortText* words : lesser)
      if (f.last_error.empty()) f.last_error = *words;
    latest_health.write(f);

    HandReport r;
    r.slipped = motion.slipped();
    r.loaded = motion.loaded();
    r.warm = watch.warm();
    r.hot = watch.hot();
    r.over_torque = watch.over_torque();
    r.bus = can.state;
    r.error_frames = can.error_frames;
    r.bus_offs = can.bus_offs;
    r.not_sent = can.not_sent;
    for (const Puck puck : kAllPucks) {
      r.silent[index(puck)] = link.silent(puck);
      r.zero_lost[index(puck)] = facts.zero_lost[index(puck)];
      r.temperature_c[index(puck)] = watch.temperature_c(puck);
    }
    for (const Puck finger : kFingerPucks) {
      const GoodPosition& p = watch.good(finger);
      r.broken_away[index(finger)] = broken_away(p.motor, p.joint);
    }
    r.mode_at_rest = mode_at_rest;
    r.palm_force_n = pad_force(link, facts, Puck::Spread, clock.now());
    r.why = motion.why();
    r.warning = watch.warning();
    r.remark = remark;
    latest_report.write(r);
  }

  /// Nobody acknowledges a setting: the modes are read once they were all taken or the time is up.
  void read_back_modes() {
    mode_at_rest = {};
    const Timestamp start = clock.now();
    const auto pump_while = [&](Duration limit, const auto& pending) {
      for (int i = 0; i < 200 && pending() && clock.now() - start < limit; ++i)
        link.pump(std::chrono::milliseconds(1));
    };
    const auto asking = [&] {
      return std::any_of(kAllPucks.begin(), kAllPucks.end(),
                         [&](Puck p) { return link.pending(p, Property::Mode); });
    };
    pump_while(kToRest, [&] { return link.busy() || asking(); });
    const Timestamp asked = clock.now();
    for (const Puck puck : kAllPucks) link.ask(puck, Property::Mode);
    pump_while(kToRest + kReadBack, asking);
    for (const Puck puck : kAllPucks) {
      const Reported& mode = link.reported(puck, Property::Mode);
      if (mode.known && mode.asked_at >= asked) mode_at_rest[index(puck)] = mode.value;
    }
  }

  [[nodiscard]] bool stale() const {
    return !watch.all_known() || seconds(clock.now() - watch.oldest_position()) > config.stale_s;
  }

  [[nodiscard]] HandState state_now() const {
    HandState s;
    s.measured_at = watch.oldest_position();
    for (const Puck finger : kFingerPucks) {
      const std::size_t f = index(finger);
      const GoodPosition& p = watch.good(finger);
      const auto angles = finger_angles(p.motor, p.joint);
      s.finger_rad[f] = angles.inner_rad;
      s.outer_rad[f] = angles.outer_rad;
      s.torque_nm[f] = strain_above_idle(link, facts, finger);
      s.tip_force_n[f] = pad_force(link, facts, finger, clock.now());
    }
    for (const Puck puck : kAllPucks) s.tactile[index(puck)] = pad_cells(link, facts, puck, clock.now());
    s.palm_force_n = pad_force(link, facts, Puck::Spread, clock.now());
    s.spread_rad = watch.good(Puck::Spread).motor / kSpreadCounts_rad;
    s.moving = motion.moving();
    s.held = motion.held();
    s.slips = motion.slipped();
    s.hot = watch.hot();
    // why a grip failed or gives way, before what may be so all the time
    const bool says_why = !motion.why().empty() && (s.slips || motion.grip_failed());
    s.warning = says_why ? motion.why() : !watch.warning().empty() ? watch.warning() : bus_words;
    if (const auto missing = watch.missing())
      say(s.warning, "{} is silent: the hand does without it", name(*missing));
    return s;
  }

  /// `although`: a silent or reset puck is no reason to refuse.
  Result<> may_act(const char* where, bool although = false) {
    if (life != Life::Active) return fail(ErrorCode::NotReady, where, "the hand is not active");
    if (bus_monitor.state() == BusMonitor::State::Up && although) return {};
    if (const auto fault = watch.fault()) return fail(fault->code, where, fault->words.str());
    if (const auto missing = watch.missing(); !although && missing)
      return fail(ErrorCode::LinkLost, where, fmt::format("{} is silent", name(*missing)));
    return {};
  }
};

BarrettHand::BarrettHand(CanBus& bus, const BarrettHandConfig& config, const Clock& clock)
    : impl_(std::make_unique<Impl>(bus, config, clock)) {}

BarrettHand::~BarrettHand() = default;

Result<> BarrettHand::configure() {
  Impl& h = *impl_;
  constexpr const char* kWhere = "hand.configure";
  if (h.config.limit_c <= h.config.warn_c)
    return h.fail(ErrorCode::BadConfig, kWhere,
                  fmt::format("limit_c ({}) has to be above warn_c ({})", h.config.limit_c, h.config.warn_c));
  if (h.config.min_torque_units > h.config.move_torque_units)
    return h.fail(ErrorCode::BadConfig, kWhere, "min_torque_units is above move_torque_units");
  h.motion.abandon();
  h.motion.forget_pressing();
  h.stop_wished = false;
  HandStartup startup(h.config, h.bus, h.link, h.facts, h.clock);
  const auto outcome = startup.run(h.motion.loaded() || h.motion.held());
  if (!outcome) {
    h.life = Impl::Life::Failed;
    return h.fail(outcome.error().code, outcome.error().where.c_str(), outcome.error().detail);
  }
  if (outcome->closed) h.motion.assume_loaded();
  h.last_error = {};
  h.remark.set(outcome->remark);
  h.bus_monitor.start();
  h.watch.start();
  h.life = Impl::Life::Configured;
  // everything is told once before the hand counts as configured
  const Timestamp start = h.clock.now();
  const auto old = [&] { return !h.watch.all_known() || h.watch.oldest_position() < start; };
  for (int i = 0; i < 1000 && old() && h.clock.now() - start < std::chrono::milliseconds(300); ++i)
    h.poll(std::chrono::milliseconds(1));
  h.publish();
  return {};
}

Result<> BarrettHand::activate() {
  Impl& h = *impl_;
  if (h.life != Impl::Life::Configured && h.life != Impl::Life::Active)
    return h.fail(ErrorCode::NotReady, "hand.activate", "the hand is not open, call configure() first");
  h.life = Impl::Life::Active;
  h.mode_at_rest = {};
  h.motion.resume();
  h.publish();
  return {};
}

void BarrettHand::deactivate() noexcept {
  Impl& h = *impl_;
  if (h.life != Impl::Life::Active) return;
  h.life = Impl::Life::Configured;
  h.motion.idle();
  h.read_back_modes();
  h.publish();
}

DeviceHealth BarrettHand::health() const {
  const Impl::Facts f = impl_->latest_health.read();
  return {f.state, f.accepted, f.rejected, f.last_error.str()};
}

HandReport BarrettHand::report() const {
  return impl_->latest_report.read();
}

Result<HandState> BarrettHand::state() {
  Impl& h = *impl_;
  constexpr const char* kWhere = "hand.state";
  if (h.life == Impl::Life::Absent || h.life == Impl::Life::Failed)
    return failure(ErrorCode::NotReady, kWhere, "the hand is not open, call configure() first");
  const Timestamp start = h.clock.now();
  const bool gap = start - h.polled_at > kGap;
  h.poll(Duration::zero());
  if (gap) {
    // answers from before the gap are old: new ones get a little time
    for (int i = 0; i < 10 && h.watch.all_known() && h.watch.oldest_position() < start &&
                    h.clock.now() - start < kCatchUp && h.bus_monitor.state() == BusMonitor::State::Up;
         ++i)
      h.poll(std::chrono::microseconds(500));
  }
  h.publish();
  if (const auto fault = h.watch.fault()) return h.fail(fault->code, where_of(*fault), fault->words.str());
  if (h.stale()) return h.fail(ErrorCode::Timeout, kWhere, "the pucks report no new positions");
  h.last_error = {};
  return h.state_now();
}

Result<> BarrettHand::preshape(double spread_rad) {
  Impl& h = *impl_;
  constexpr const char* kWhere = "hand.preshape";
  if (auto may = h.may_act(kWhere); !may) return may;
  if (!(spread_rad >= 0.0 && spread_rad <= std::numbers::pi))
    return h.fail(ErrorCode::LimitExceeded, kWhere,
                  fmt::format("a spread of {} rad, expected 0 to pi", spread_rad));
  if (h.motion.loaded() || h.motion.held() || h.motion.phase() == HandMotion::Phase::Closing)
    return h.fail(ErrorCode::NotReady, kWhere, "the hand holds something, or may: only release() opens it");
  h.motion.preshape(spread_rad);
  return {};
}

Result<> BarrettHand::close(double torque_nm) {
  Impl& h = *impl_;
  constexpr const char* kWhere = "hand.close";
  if (auto may = h.may_act(kWhere); !may) return may;
  if (!(torque_nm > 0.0 && torque_nm <= h.config.max_torque_nm))
    return h.fail(ErrorCode::LimitExceeded, kWhere,
                  fmt::format("a torque of {} N m, expected more than 0 and at most {} N m", torque_nm,
                              h.config.max_torque_nm));
  if (h.watch.hot())
    return h.fail(ErrorCode::DeviceFault, kWhere,
                  fmt::format("the hand has {:.0f} C (limit {:.0f}): it has to cool first",
                              h.watch.hottest_c(), h.config.limit_c));
  h.motion.close(torque_nm);
  return {};
}

Result<> BarrettHand::release() {
  Impl& h = *impl_;
  if (auto may = h.may_act("hand.release", /*although=*/true); !may) return may;
  h.watch.go_without_silent();
  h.motion.release();
  return {};
}

void BarrettHand::stop() noexcept {
  impl_->stop_wished = true;
}

bool fingers_rest(const HandReport& report) {
  return std::all_of(kFingerPucks.begin(), kFingerPucks.end(),
                     [&](Puck p) { return report.mode_at_rest[index(p)] == kModeIdle; });
}

std::string motors_at_rest(const HandReport& report) {
  std::string rests, keeps, on, unknown;
  const auto add = [](std::string& to, std::string words) {
    to += to.empty() ? std::move(words) : ", " + words;
  };
  for (const Puck puck : kAllPucks) {
    const auto& mode = report.mode_at_rest[index(puck)];
    if (!mode)
      add(unknown, std::string(name(puck)));
    else if (*mode == kModeIdle)
      add(rests, std::string(name(puck)));
    else if (*mode == kModePid && puck == Puck::Spread)
      add(keeps, std::string(name(puck)));
    else
      add(on, fmt::format("{} (MODE {})", name(puck), *mode));
  }
  std::string text;
  const auto group = [&](const std::string& who, const char* what) {
    if (!who.empty()) text += fmt::format("{}{}: {}", text.empty() ? "" : "; ", what, who);
  };
  group(rests, "motors at rest, as read back");
  group(keeps, "keeps its angle");
  group(on, "STILL ON");
  group(unknown, "not read back, unknown");
  return text;
}

}  // namespace colift::hal
