// What a client does wrong without the hand saying so.
#include <fmt/format.h>

#include <cmath>

#include "sim_hal/emulator/hand/hand_emulator.hpp"

namespace colift::sim_hal {
namespace {

using namespace prop;

constexpr hal::Duration kHurried = std::chrono::microseconds(100);
constexpr std::int32_t kShut = 12'000;  // 0.15 rad: such a finger is in the spread's way
constexpr std::int32_t kTurns = 1'000;  // 5 degrees of spread
constexpr std::int32_t kMostTorque = 5'000;
constexpr std::array<const char*, kHandPucks> kNames{"F1", "F2", "F3", "spread"};

bool risky(int property) {
  for (const int p : {6, 7, 12, 13, kId, kSave, kDef, 61})
    if (p == property) return true;
  return false;
}

}  // namespace

void HandEmulator::broke(HandRule rule, std::string how, bool excused) {
  const auto r = static_cast<std::size_t>(rule);
  if (excused) {
    if (report_.excused[r]++ == 0) event(fmt::format("{}, because of a fault: {}", kHandRuleNames[r], how));
    return;
  }
  if (report_.broken[r]++ > 0) return;
  event(fmt::format("{}: {}", kHandRuleNames[r], how));
  report_.first[r] = std::move(how);
}

// It cannot know so soon that the puck sleeps.
bool HandEmulator::asleep_by_fault(std::size_t puck) const {
  return faulted_[puck] && pucks_[puck].life() != HandPuck::Life::Ready;
}

void HandEmulator::judge_set(std::size_t p, int property, std::int32_t value, hal::Timestamp at) {
  const HandPuck& puck = pucks_[p];
  if (risky(property))
    broke(HandRule::Risky, fmt::format("{} of {}", hand_property_name(property), kNames[p]));
  if (config_.judges_pace && last_set_[p] > hal::Timestamp(0) && at - last_set_[p] < kHurried)
    broke(HandRule::Hurried, fmt::format("{} of {} {} us after another setting", hand_property_name(property),
                                         kNames[p], (at - last_set_[p]).count() / 1000));
  last_set_[p] = at;
  if (!puck.ready()) return;
  const auto far = [&](std::int32_t goal) { return std::abs(1.0 * goal - puck.position()) > kTurns; };
  if (property == kE && puck.value(kMode) == 5 && puck.get(kV).value_or(0) != 0 && far(puck.value(kE)) &&
      value != puck.value(kE))
    broke(HandRule::NewEnd, fmt::format("{} is moving to {}, commanded {}", kNames[p], puck.value(kE), value),
          faulted_[p]);
  if (property == kMt && value > kMostTorque)
    broke(HandRule::TooMuchTorque, fmt::format("MT {} for {}", value, kNames[p]));
  if (property == kMode && value >= 2 && value <= 4 && puck.value(kTstop) > 0)
    broke(HandRule::StreamWithStop,
          fmt::format("MODE {} of {} with TSTOP {}", value, kNames[p], puck.value(kTstop)));
  const bool turns =
      p == kHandSpread && ((property == kMode && value == 5 && far(puck.value(kE))) ||
                           (property == kM && far(value)) || (property == kCmd && value == 13));
  if (!turns) return;
  for (std::size_t f = 0; f < kHandFingers; ++f)
    if (plant_.joint(f).motor > kShut)
      broke(HandRule::FingersInTheWay,
            fmt::format("the spread turns while {} is at {:.0f} counts", kNames[f], plant_.joint(f).motor),
            faulted_[f] || faulted_[kHandSpread]);
}

}  // namespace colift::sim_hal
