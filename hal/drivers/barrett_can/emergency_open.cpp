#include "hal/drivers/barrett_can/emergency_open.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>

#include "hal/drivers/barrett_can/hand_units.hpp"
#include "hal/drivers/barrett_can/pucks/puck_link.hpp"
#include "hal/drivers/barrett_can/pucks/wait_on.hpp"
#include "hal/types/units.hpp"

namespace colift::hal {
namespace {

using namespace barrett;

constexpr const char* kWhere = "hand.emergency_open";
constexpr double kAnswer_s = 0.35;                                    // three tries, on a slow link too
constexpr double kSettings_s = 0.3;                                   // six settings, read back
constexpr std::int32_t kTravel = kClosedCounts + kClosedCounts / 10;  // beyond the open stop from anywhere
constexpr std::int32_t kStill = 50;                                   // counts between two looks

Duration of_seconds(double s) {
  return std::chrono::nanoseconds(static_cast<std::int64_t>(1e9 * s));
}

class Opener {
 public:
  Opener(CanBus& bus, const Clock& clock, const BarrettHandConfig& config,
         const std::function<bool()>& interrupted)
      : clock_(clock),
        config_(config),
        interrupted_(interrupted),
        link_(bus, clock, of_seconds(1e-3 * config.reply_ms), of_seconds(1e-3 * config.tactile_reply_ms)) {}

  Result<std::array<FingerOpening, 3>> run() {
    link_.measure_round_trip(of_seconds(kAnswer_s));
    find();
    if (std::none_of(fingers_.begin(), fingers_.end(), [](const auto& f) { return f.answers; }))
      return failure(ErrorCode::LinkLost, kWhere,
                     "no finger answers: is the hand's supply on (48 V), and is this its bus?");
    for (const Puck finger : kFingerPucks)
      if (of(finger).answers) start(finger);
    (void)wait(config_.move_s, [&] { return all_stand(); });
    rest();
    return fingers_;
  }

 private:
  FingerOpening& of(Puck finger) { return fingers_[index(finger)]; }

  /// False when the time is up first.
  bool wait(double limit_s, const std::function<bool()>& until) {
    return wait_on(link_, clock_, of_seconds(limit_s), until, [&] { return !ending_ && interrupted_(); });
  }

  /// Of every finger that answers within three tries.
  void ask(Property property) {
    for (const Puck finger : kFingerPucks) link_.ask(finger, property);
    (void)wait(kAnswer_s, [&] {
      return std::none_of(kFingerPucks.begin(), kFingerPucks.end(),
                          [&](Puck finger) { return link_.pending(finger, property); });
    });
  }

  void find() {
    ask(Property::Stat);
    bool woken = false;
    for (const Puck finger : kFingerPucks) {
      const Reported& stat = link_.reported(finger, Property::Stat);
      if (!stat.known || stat.value != kStatReset) continue;
      link_.set(finger, Property::Stat, kStatReady, false);
      woken = true;
    }
    // a puck that boots acknowledges nothing: whoever talks meanwhile drives the bus off
    if (woken) {
      (void)wait(0.01, [] { return false; });
      (void)wait(config_.boot_s + 0.5 * config_.wake_s, [] { return false; });
      for (const Puck finger : kFingerPucks) link_.forget(finger);
    }
    ask(Property::P);
    for (const Puck finger : kFingerPucks) {
      const Reported& p = link_.reported(finger, Property::P);
      of(finger) = {p.known, p.value, p.value, false};
    }
  }

  // by its own counts: one that lost its zero is as far from its stop as any
  void start(Puck finger) {
    link_.set(finger, Property::Mode, kModeIdle, true);
    link_.set(finger, Property::Mt, static_cast<std::int32_t>(config_.move_torque_units), false);
    link_.set(finger, Property::Tstop, static_cast<std::int32_t>(config_.stopped_ms), false);
    link_.set(finger, Property::Hsg, 0, false);
    link_.set(finger, Property::E, of(finger).from - kTravel, false);
    link_.set(finger, Property::Mode, kModeTrapezoid, false);
    stands_since_[index(finger)] = clock_.now() + of_seconds(kSettings_s);
  }

  bool all_stand() {
    bool all = true;
    for (const Puck finger : kFingerPucks) {
      if (!of(finger).answers) continue;
      const Reported& p = link_.reported(finger, Property::P);
      if (std::abs(p.value - of(finger).to) > kStill) {
        of(finger).to = p.value;
        stands_since_[index(finger)] = std::max(stands_since_[index(finger)], clock_.now());
      }
      if (!link_.pending(finger, Property::P) && !link_.silent(finger)) link_.ask(finger, Property::P);
      all = all && (link_.silent(finger) ||
                    clock_.now() - stands_since_[index(finger)] > of_seconds(config_.still_s));
    }
    return all;
  }

  void rest() {
    ending_ = true;  // the motors come to rest whoever interrupts
    for (const Puck finger : kFingerPucks) {
      if (!of(finger).answers) continue;
      link_.drop_settings(finger);
      link_.set(finger, Property::Mode, kModeIdle, true);
    }
    const Timestamp set_at = clock_.now();
    (void)wait(kSettings_s, [&] { return !link_.busy(); });
    ask(Property::Mode);
    for (const Puck finger : kFingerPucks) {
      const Reported& mode = link_.reported(finger, Property::Mode);
      of(finger).rests = mode.known && mode.asked_at >= set_at && mode.value == kModeIdle;
    }
  }

  const Clock& clock_;
  const BarrettHandConfig& config_;
  const std::function<bool()>& interrupted_;
  PuckLink link_;
  bool ending_ = false;
  std::array<FingerOpening, 3> fingers_{};
  std::array<Timestamp, kPucks> stands_since_{};
};

}  // namespace

Result<std::array<FingerOpening, 3>> emergency_open(CanBus& bus, const Clock& clock,
                                                    const BarrettHandConfig& config,
                                                    const std::function<bool()>& interrupted) {
  if (auto opened = bus.open(); !opened) return tl::unexpected(opened.error());
  return Opener(bus, clock, config, interrupted).run();
}

double FingerOpening::opened_deg() const {
  return rad_to_deg((from - to) / kFingerCounts_rad);
}

std::string describe(const std::array<FingerOpening, 3>& fingers) {
  std::string text;
  for (std::size_t i = 0; i < fingers.size(); ++i) {
    const FingerOpening& f = fingers[i];
    if (!f.answers)
      text += fmt::format("F{} does not answer and was not opened\n", i + 1);
    else
      text += fmt::format("F{} opened by {:.0f} degrees; {}\n", i + 1, f.opened_deg(),
                          f.rests ? "its motor rests" : "its motor was not read back as resting");
  }
  return text;
}

}  // namespace colift::hal
