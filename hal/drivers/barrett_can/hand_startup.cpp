#include "hal/drivers/barrett_can/hand_startup.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cstdlib>
#include <vector>

#include "hal/drivers/barrett_can/calibration/hand_calibration.hpp"
#include "hal/drivers/barrett_can/pucks/wait_on.hpp"

namespace colift::hal::barrett {
namespace {

constexpr const char* kWhere = "hand.configure";
constexpr int kOldestFirmware = 132, kOldestTactile = 142;
constexpr Duration kMeasuring = std::chrono::milliseconds(500);  // of the link, before it is known
constexpr double kAccel_q8 = 200.0;
constexpr std::int32_t kClosedFrom = 12'000;  // 0.15 rad: such a finger may hold something

tl::unexpected<Error> fault(std::string words) {
  return failure(ErrorCode::DeviceFault, kWhere, std::move(words));
}

}  // namespace

double HandStartup::one_answer_s() const {
  return std::max(0.1, seconds(link_.three_tries()) + 0.02);
}

HandStartup::HandStartup(const BarrettHandConfig& config, CanBus& bus, PuckLink& link, HandFacts& facts,
                         const Clock& clock)
    : config_(config), bus_(bus), link_(link), facts_(facts), clock_(clock) {}

bool HandStartup::wait(double limit_s, const std::function<bool()>& until) {
  return wait_on(link_, clock_, duration_of(limit_s), until);
}

std::optional<std::int32_t> HandStartup::read(Puck puck, Property property, double limit_s) {
  const Timestamp start = clock_.now();
  const bool reported = wait(limit_s, [&] {
    const Reported& t = link_.reported(puck, property);
    if (t.known && t.asked_at >= start) return true;
    if (!link_.pending(puck, property)) link_.ask(puck, property);
    return false;
  });
  if (!reported) return std::nullopt;
  return link_.reported(puck, property).value;
}

Result<> HandStartup::settings_taken(double limit_s) {
  const bool done = wait(limit_s, [&] { return !link_.busy(); });
  for (const Puck puck : kAllPucks)
    if (const auto refused = link_.take_refusal(puck))
      return fault(fmt::format("{} does not take {}", name(puck), property_info(*refused).name));
  if (!done) return failure(ErrorCode::LinkLost, kWhere, "the settings did not get through to the pucks");
  return {};
}

// What silence of all four means, as far as error frames tell.
tl::unexpected<Error> HandStartup::nobody() const {
  const CanHealth now = bus_.health();
  const auto lost = [](std::string words) { return failure(ErrorCode::LinkLost, kWhere, std::move(words)); };
  if (now.state == CanHealth::State::Down || now.state == CanHealth::State::Closed)
    return lost("the CAN interface went down while the pucks were asked");
  if (now.bus_errors > before_.bus_errors)
    return lost(
        fmt::format("no puck answers, and the bus reports {} broken frames: another bit rate than 1 Mbit/s, "
                    "or no termination (120 ohm at both ends, a switch at the hand's supply)",
                    now.bus_errors - before_.bus_errors));
  if (now.not_acknowledged > before_.not_acknowledged || now.state != CanHealth::State::Active)
    return lost(
        "no puck answers and nobody on the bus acknowledges: is the hand's supply on (48 V), the cable in, "
        "the bus terminated (a switch at the supply)?");
  if (now.not_sent > before_.not_sent)
    return lost(
        "the adapter takes no frames: nobody acknowledges, or it is stuck; check the hand's supply, then "
        "unplug it");
  if (!now.reports_errors)
    return lost(
        "no puck answers; whether anybody is on the bus is not known, because the gateway reports no "
        "error frames (socketcand -e 1FFFFFFF does): is the hand's supply on (48 V), the cable in, the bus "
        "terminated, and is this its bus?");
  return lost(
      "no puck answers, though the bus reports no errors: is the hand's supply on (48 V), and is this its "
      "bus?");
}

Result<> HandStartup::find_pucks() {
  link_.measure_round_trip(kMeasuring);
  for (const Puck puck : kAllPucks) link_.ask(puck, Property::Stat);
  (void)wait(one_answer_s(), [&] {
    return std::none_of(kAllPucks.begin(), kAllPucks.end(),
                        [&](Puck p) { return link_.pending(p, Property::Stat); });
  });
  std::vector<std::string_view> here, silent;
  for (const Puck puck : kAllPucks) {
    // once more, alone
    const bool answers =
        link_.reported(puck, Property::Stat).known || read(puck, Property::Stat, one_answer_s());
    (answers ? here : silent).push_back(name(puck));
  }
  if (here.empty()) return nobody();
  if (!silent.empty())
    return failure(
        ErrorCode::LinkLost, kWhere,
        fmt::format("{} answer{}, {} silent: a broken puck or its cable inside the hand",
                    fmt::join(here, ", "), here.size() == 1 ? "s" : "",
                    fmt::format("{} {}", fmt::join(silent, ", "), silent.size() == 1 ? "is" : "are")));
  return {};
}

Result<> HandStartup::wake() {
  constexpr int kTries = 3;  // nobody acknowledges a setting
  for (int tries = 0; tries < kTries; ++tries) {
    bool woken = false;
    for (const Puck puck : kAllPucks) {
      if (link_.reported(puck, Property::Stat).value != kStatReset) continue;
      facts_.zero_lost[index(puck)] = true;
      facts_.jumped_by[index(puck)] = 0;
      link_.forget_settings(puck);
      link_.set(puck, Property::Stat, kStatReady, false);
      rest(0.01);
      woken = true;
    }
    // a puck that boots acknowledges nothing: whoever talks now drives the bus off
    if (woken) rest(config_.boot_s);
    bool asleep = false;
    for (const Puck puck : kAllPucks) {
      link_.forget(puck);
      const auto stat = read(puck, Property::Stat, woken ? config_.wake_s : one_answer_s());
      if (!stat)
        return failure(ErrorCode::LinkLost, kWhere,
                       fmt::format("{} is silent {:.1f} s after it was woken", name(puck),
                                   config_.boot_s + config_.wake_s));
      if (*stat == kStatError)
        return fault(fmt::format("{} reports an error (code {})", name(puck),
                                 read(puck, Property::Error, one_answer_s()).value_or(-1)));
      asleep = asleep || *stat == kStatReset;
    }
    if (!asleep) return {};
  }
  for (const Puck puck : kAllPucks)
    if (const auto stat = link_.reported(puck, Property::Stat).value; stat != kStatReady)
      return fault(
          fmt::format("{} does not wake up: its status is {}, expected {}", name(puck), stat, kStatReady));
  return {};
}

Result<> HandStartup::identify() {
  facts_.has_strain = true;
  facts_.has_tactile = config_.tactile != "off";
  facts_.tactile_format = config_.tactile == "top10" ? kTactTop10 : kTactFull;
  facts_.pad_works = {};
  for (const Puck puck : kAllPucks) {
    const auto version = read(puck, Property::Vers, one_answer_s()),
               role = read(puck, Property::Role, one_answer_s());
    const auto turn = read(puck, Property::Cts, one_answer_s()),
               ct = read(puck, Property::Ct, one_answer_s());
    if (!version || !role || !turn || !ct)
      return failure(ErrorCode::LinkLost, kWhere, fmt::format("{} does not say who it is", name(puck)));
    if ((*role & kRoleProduct) != kProductHand)
      return fault(fmt::format("node {} is no puck of a BarrettHand: its role is {:#06x}", node_id(puck),
                               *role & 0xffff));
    if (*version < kOldestFirmware)
      return fault(fmt::format("{} has firmware {}; its properties have other numbers before {}", name(puck),
                               *version, kOldestFirmware));
    if (*turn != static_cast<std::int32_t>(kCountsPerTurn))
      return fault(fmt::format("{} counts {} per turn of its motor, expected {:.0f}", name(puck), *turn,
                               kCountsPerTurn));
    marked_[index(puck)] = *ct == zero_mark(puck);
    if (puck != Puck::Spread && (*role & kRoleStrain) == 0) facts_.has_strain = false;
    if (puck != Puck::Spread) {
      const auto otemp = read(puck, Property::Otemp, one_answer_s());
      if (otemp && *otemp >= 20 && *otemp <= 100) facts_.otemp_c[index(puck)] = *otemp;
    }
    if (config_.tactile == "off" || (*role & kRoleTactile) == 0) continue;
    if (*version < kOldestTactile) {
      add_remark(
          fmt::format("{} has firmware {}: tactile pads need {}", name(puck), *version, kOldestTactile));
    } else if (const auto id = read(puck, Property::Tactid, one_answer_s()); !id || *id == kTactidBroken) {
      add_remark(fmt::format("the tactile pad of {} did not start and is not used", name(puck)));
      link_.forget(puck);
    } else {
      facts_.pad_works[index(puck)] = true;
    }
  }
  facts_.has_tactile = facts_.pad_works[0] || facts_.pad_works[1] || facts_.pad_works[2];
  return {};
}

Result<> HandStartup::read_scales() {
  facts_.strain_scale.fill(1.0);
  facts_.units_per_nm.fill(config_.torque_units_per_nm);
  if (config_.calibration_file.empty()) return {};
  const auto calibration = load_hand_calibration(config_.calibration_file);
  if (!calibration) return tl::unexpected(calibration.error());
  for (const Puck finger : kFingerPucks) {
    const auto serial = read(finger, Property::Sn, one_answer_s());
    const PuckScale* scale = serial ? calibration->of(*serial) : nullptr;
    if (!scale) {
      add_remark(serial ? fmt::format("{} (puck {}) is not in {}: the maker's curve", name(finger), *serial,
                                      config_.calibration_file)
                        : fmt::format("{} does not tell its serial number: the maker's curve", name(finger)));
      continue;
    }
    facts_.strain_scale[index(finger)] = scale->strain_scale;
    if (scale->torque_points > 0) facts_.units_per_nm[index(finger)] = scale->torque_units_per_nm;
  }
  return {};
}

Result<> HandStartup::join_group() {
  for (const Puck puck : kAllPucks) {
    bool member = false;
    for (const Property group : {Property::GrpA, Property::GrpB, Property::GrpC})
      member = member || read(puck, group, one_answer_s()) == kHandGroup;
    // hands of 2010 listen to group 8; in RAM only, nothing is ever saved
    if (!member) link_.set(puck, Property::GrpC, kHandGroup, true);
  }
  const bool joined = wait(1.0, [&] { return !link_.busy(); });
  bool all = joined;
  for (const Puck puck : kAllPucks) all = !link_.take_refusal(puck) && all;
  link_.use_group(all);
  if (!all) add_remark("not every puck joins the hand's group: they are asked one by one");
  return {};
}

Result<> HandStartup::write_working_values(bool loaded) {
  for (const Puck puck : kAllPucks) {
    const bool spread = puck == Puck::Spread;
    const double speed = spread ? config_.spread_speed_rad_s * kSpreadCounts_rad
                                : config_.finger_speed_rad_s * kFingerCounts_rad;
    // a motor that presses or holds goes on doing so
    if (!loaded) {
      link_.set(puck, Property::Mode, kModeIdle, true);
      link_.set(puck, Property::Mt, static_cast<std::int32_t>(config_.move_torque_units), true);
      link_.set(puck, Property::Tstop, static_cast<std::int32_t>(config_.stopped_ms), true);
    }
    link_.set(puck, Property::Mv, static_cast<std::int32_t>(std::lround(speed / 1000.0)), true);
    link_.set(puck, Property::Accel, static_cast<std::int32_t>(kAccel_q8), true);
    link_.set(puck, Property::Hold, spread ? 1 : 0, true);
  }
  return settings_taken(2.0);
}

// A program that was killed leaves its motors on.
void HandStartup::name_pressing() {
  std::vector<std::string> on;
  for (const Puck finger : kFingerPucks) {
    const auto mode = read(finger, Property::Mode, one_answer_s());
    if (mode && *mode != kModeIdle) on.push_back(fmt::format("{} (MODE {})", name(finger), *mode));
  }
  if (!on.empty())
    add_remark(fmt::format("found with motors on, left so by another program: {}", fmt::join(on, ", ")));
}

void HandStartup::add_remark(const std::string& words) {
  remark_ += (remark_.empty() ? "" : "; ") + words;
}

void HandStartup::tare() {
  for (const Puck puck : kAllPucks) {
    if (!facts_.pad_works[index(puck)]) continue;
    link_.set(puck, Property::Tact, kTactOff, false);
    link_.set(puck, Property::Tact, kTactTare, false);
  }
  (void)wait(0.1, [&] { return !link_.busy(); });
  if (!facts_.has_strain) return;
  constexpr int kReadings = 8;
  for (const Puck finger : kFingerPucks) {
    double sum = 0.0;
    int count = 0;
    for (int i = 0; i < kReadings; ++i)
      if (const auto sg = read(finger, Property::Sg, one_answer_s())) sum += *sg, ++count;
    if (count > 0) facts_.strain_idle[index(finger)] = sum / count;
    if (facts_.strain_idle[index(finger)] < 1500.0 || facts_.strain_idle[index(finger)] > 2600.0)
      add_remark(fmt::format("the strain gauge of {} shows {:.0f} without load, expected about 2000",
                             name(finger), facts_.strain_idle[index(finger)]));
  }
}

// Pads on, the spread held where it is, everything told once.
Result<> HandStartup::settle(bool loaded) {
  for (const Puck puck : kAllPucks) {
    if (!facts_.pad_works[index(puck)]) continue;
    link_.ask_tactile(puck, facts_.tactile_format, /*send=*/false);
    link_.set(puck, Property::Tact, facts_.tactile_format, false);
  }
  if (!loaded && !facts_.zero_lost[index(Puck::Spread)]) {
    const auto at = read(Puck::Spread, Property::P, one_answer_s());
    if (!at)
      return failure(ErrorCode::LinkLost, kWhere,
                     "the spread answers, but not about its position: check its group and firmware");
    link_.set(Puck::Spread, Property::E, *at, true);
    link_.set(Puck::Spread, Property::Mode, kModeTrapezoid, false);
  }
  if (auto taken = settings_taken(1.0); !taken) return taken;
  for (const Puck puck : kAllPucks) {
    for (const Property p : {Property::P, Property::Mode, Property::Mt, Property::Temp, Property::Therm})
      if (!read(puck, p, one_answer_s()))
        return failure(ErrorCode::LinkLost, kWhere,
                       fmt::format("{} does not answer about {}", name(puck), property_info(p).name));
  }
  if (facts_.has_tactile)
    (void)wait(1e-3 * config_.tactile_reply_ms, [&] {
      return std::all_of(kFingerPucks.begin(), kFingerPucks.end(),
                         [&](Puck p) { return link_.pad(p).known || !facts_.pad_works[index(p)]; });
    });
  return {};
}

Result<HandStartup::Outcome> HandStartup::run(bool loaded) {
  remark_.clear();
  const auto state = bus_.health().state;
  if (state == CanHealth::State::Closed || state == CanHealth::State::Down ||
      state == CanHealth::State::BusOff)
    if (auto opened = bus_.open(); !opened) return tl::unexpected(opened.error());
  before_ = bus_.health();
  link_.drop_all();
  link_.clear_full();
  for (const Puck puck : kAllPucks) {
    link_.forget(puck);
    link_.forget_settings(puck);
    (void)link_.take_refusal(puck);
  }
  facts_.mode_lost = {};
  if (auto found = find_pucks(); !found) return tl::unexpected(found.error());
  if (auto awake = wake(); !awake) return tl::unexpected(awake.error());
  if (auto known = identify(); !known) return tl::unexpected(known.error());
  if (auto known = read_scales(); !known) return tl::unexpected(known.error());
  if (auto joined = join_group(); !joined) return tl::unexpected(joined.error());

  name_pressing();

  Outcome outcome;
  bool needed = config_.initialise == "always";
  for (const Puck puck : kAllPucks) {
    if (const std::string doubt = doubt_zero(puck); !doubt.empty()) {
      // nothing is opened on a suspicion: closed fingers may hold something
      if (!loaded && config_.initialise != "always")
        return failure(ErrorCode::NotReady, kWhere, doubt + ": free the hand, then colift hal hand init");
      marked_[index(puck)] = false;
    }
    if (!marked_[index(puck)]) facts_.zero_lost[index(puck)] = true;
    needed = needed || facts_.zero_lost[index(puck)];
  }
  if (!loaded && !needed) {
    // another program left it so, and may have left something in it
    for (const Puck finger : kFingerPucks)
      outcome.closed = outcome.closed || read(finger, Property::P, one_answer_s()).value_or(0) > kClosedFrom;
  }
  const bool keep = loaded || outcome.closed;
  if (auto written = write_working_values(keep); !written) return tl::unexpected(written.error());
  if (needed && !keep) {
    if (config_.initialise == "never")
      return failure(
          ErrorCode::NotReady, kWhere,
          "the hand does not know its zero and may not look for it (initialise: never): free it, then "
          "colift hal hand init");
    if (auto done = initialise(); !done) return tl::unexpected(done.error());
  }
  if (!keep) tare();
  if (auto settled = settle(keep); !settled) return tl::unexpected(settled.error());
  if (link_.round_trip().slow())
    add_remark(fmt::format("slow link: the pucks answer after {:.1f} ms (expected within {:g})",
                           link_.round_trip().worst_ms(), config_.reply_ms));
  outcome.remark = remark_;
  return outcome;
}

}  // namespace colift::hal::barrett
