// Start-up: the zeros of the joints, found against the stops or believed from before.
#include <fmt/format.h>

#include <cmath>
#include <cstdlib>

#include "hal/drivers/barrett_can/hand_startup.hpp"

namespace colift::hal::barrett {
namespace {

constexpr const char* kWhere = "hand.configure";
constexpr std::int32_t kZeroTolerance = 500;
constexpr double kHiSilence_s = 1.0;        // the pucks say nothing for half a second after CMD 13
constexpr std::int32_t kCounts_s = 32'768;  // of UPSECS, which begins anew then
constexpr double kSameStart_s = 20.0;       // two clocks
// Of an encoder that counts from the joint's zero: motor and joint agree, but for what breakaway adds.
constexpr double kBehindJoint = -8'000.0;  // counts: 0.1 rad of play in the gears
constexpr double kOuterMost_rad = 0.95;    // 48 degrees, and play
constexpr std::int32_t kMotorMost = 203'000, kMotorLeast = -4'000;

tl::unexpected<Error> fault(std::string words) {
  return failure(ErrorCode::DeviceFault, kWhere, std::move(words));
}

// Seconds of our clock at which a puck was switched on, modulo what it can count.
double power_on_s(Timestamp now, std::int32_t up_s) {
  const double on = std::fmod(seconds(now) - up_s, kCounts_s);
  return on < 0.0 ? on + kCounts_s : on;
}

}  // namespace

// CT tells an initialised puck until it is reset, if nobody saved it to flash: then every reset brings it
// back, wherever the finger stands. So the moment of power-on goes with it, in the step of commands that
// nobody here uses; another moment is another life. And the joint's encoder has to agree with the motor's.
std::string HandStartup::doubt_zero(Puck puck) {
  const auto up = read(puck, Property::Upsecs, one_answer_s());
  const auto noted = read(puck, Property::Ds, one_answer_s());
  up_s_[index(puck)] = up;
  if (!marked_[index(puck)]) return {};
  if (up && noted && *noted >= 0) {
    const double apart = std::abs(power_on_s(clock_.now(), *up & (kCounts_s - 1)) - *noted);
    if (std::min(apart, kCounts_s - apart) > kSameStart_s)
      return fmt::format("the zero of {} is of an earlier life of the puck (up for {} s) or of this computer",
                         name(puck), *up);
  }
  const auto p = read(puck, Property::P, one_answer_s());
  const Reported& joint = link_.reported(puck, Property::Jp);
  if (puck == Puck::Spread || !p || !joint.known) return {};
  const double outer_rad = finger_angles(*p, joint.value).outer_rad;
  if (*p - 2.5 * joint.value < kBehindJoint || outer_rad > kOuterMost_rad || *p > kMotorMost ||
      *p < kMotorLeast)
    return fmt::format("motor and joint encoder of {} contradict each other ({} and {} counts)", name(puck),
                       *p, joint.value);
  return {};
}

// -1 where the puck's clock does not run: then nothing can be said by it.
Result<> HandStartup::note_power_on() {
  for (const Puck puck : kAllPucks) {
    const auto up = read(puck, Property::Upsecs, one_answer_s());
    const bool runs = up && up_s_[index(puck)] && *up != *up_s_[index(puck)];
    const double on = runs ? power_on_s(clock_.now(), *up & (kCounts_s - 1)) : -1.0;
    link_.set(puck, Property::Ds, static_cast<std::int32_t>(std::lround(on)) % kCounts_s, true);
  }
  return settings_taken(1.0);
}

// A puck that looks for its stop says nothing for half a second. One that says at once that it is idle did
// not get the command, and its position, 0 after a reset, would be taken for that of the stop.
void HandStartup::start_finding(const Puck* first, std::size_t count) {
  constexpr int kTries = 3;
  std::array<bool, kPucks> started{};
  for (int tries = 0; tries < kTries; ++tries) {
    for (std::size_t i = 0; i < count; ++i) {
      if (started[i]) continue;
      link_.forget(first[i]);
      link_.set(first[i], Property::Cmd, kCmdInitialise, false);
    }
    (void)wait(one_answer_s(), [&] { return !link_.busy(); });
    rest(0.03);
    for (std::size_t i = 0; i < count; ++i)
      if (!started[i]) link_.ask(first[i], Property::Mode);
    (void)wait(one_answer_s(), [&] {
      return std::none_of(first, first + count, [&](Puck p) { return link_.pending(p, Property::Mode); });
    });
    bool all = true;
    for (std::size_t i = 0; i < count; ++i) {
      const Reported& mode = link_.reported(first[i], Property::Mode);
      started[i] = !mode.known || (mode.value != kModeIdle && mode.value != kModePid);
      all = all && started[i];
    }
    if (all) return;
  }
}

Result<> HandStartup::find_stops(const Puck* first, std::size_t count, double timeout_s) {
  start_finding(first, count);
  rest(kHiSilence_s);
  for (std::size_t i = 0; i < count; ++i) link_.forget(first[i]);
  for (std::size_t i = 0; i < count; ++i) {
    const Puck puck = first[i];
    std::optional<std::int32_t> mode;
    const bool stopped = wait(timeout_s, [&] {
      const Reported& reported = link_.reported(puck, Property::Mode);
      if (reported.known &&
          (reported.value == kModeIdle || (puck == Puck::Spread && reported.value == kModePid))) {
        mode = reported.value;
        return true;
      }
      if (!link_.pending(puck, Property::Mode)) link_.ask(puck, Property::Mode);
      return false;
    });
    if (!stopped)
      return fault(fmt::format("{} did not find its stop within {:.0f} s: is something blocking it?",
                               name(puck), timeout_s));
    const auto at = read(puck, Property::P, one_answer_s());
    if (!at)
      return failure(ErrorCode::LinkLost, kWhere,
                     fmt::format("{} reports no position after initialising", name(puck)));
    const Reported& joint = link_.reported(puck, Property::Jp);
    if (std::abs(*at) > kZeroTolerance || (joint.known && std::abs(joint.value) > kZeroTolerance))
      return fault(
          fmt::format("{} is at {} counts (joint {}) after initialising, expected 0 within {}: did it meet "
                      "something blocking it?",
                      name(puck), *at, joint.known ? joint.value : 0, kZeroTolerance));
    facts_.zero_lost[index(puck)] = false;
    facts_.jumped_by[index(puck)] = 0;
  }
  return {};
}

Result<> HandStartup::initialise() {
  // old answers about the mode are from before
  for (const Puck puck : kAllPucks) link_.forget(puck);
  // fingers first: closed ones would meet the turning ones; once more, for they may have met each other
  auto fingers = find_stops(kFingerPucks.data(), kFingerPucks.size(), config_.finger_initialise_s);
  if (!fingers) {
    for (const Puck puck : kFingerPucks) link_.forget(puck);
    fingers = find_stops(kFingerPucks.data(), kFingerPucks.size(), config_.finger_initialise_s);
  }
  if (!fingers) return fingers;
  const Puck spread = Puck::Spread;
  if (auto turned = find_stops(&spread, 1, config_.spread_initialise_s); !turned) return turned;
  for (const Puck puck : kAllPucks) link_.set(puck, Property::Ct, zero_mark(puck), true);
  if (auto marked = settings_taken(1.0); !marked) return marked;
  return note_power_on();
}

}  // namespace colift::hal::barrett
