#include "control/recovery/recovery_machine.hpp"

#include <algorithm>
#include <array>

namespace colift::control {
namespace {

using enum RecoveryStep;
using enum RecoveryEvent;

constexpr std::string_view kDeclined = "not confirmed: the arm holds, the grip stays as it is";
constexpr std::string_view kInterrupted = "interrupted: the arm holds, the grip stays as it is";
constexpr std::string_view kLost = "arm or hand does not answer: it has stopped by itself";
constexpr std::string_view kMet = "unexpected contact: free the arm and the hand, then it is tried again";
constexpr std::string_view kHit = "unexpected contact: the arm holds";

constexpr auto kRules = std::to_array<RecoveryRule>({
    {Assess, HandHolds, Lower, "the hand may hold an object: it is lowered first"},
    {Assess, HandOpen, DrawBack, "the hand is open"},
    {Assess, RecoveryEvent::AtHome, Done, "the hand is open and the arm is at home"},
    {Assess, HandUnknown, Held, "the hand does not answer: whether it holds something is unknown"},
    {Assess, Interrupted, Held, kInterrupted},
    {Assess, DeviceLost, Held, kLost},
    {Assess, TimeOut, Held, "timeout: the devices did not report their state"},

    {Lower, Supported, Release, "the object is supported"},
    {Lower, PersonHolds, TakeOver, "the operator says that a person holds the object"},
    {Lower, NoGround, TakeOver, "found no ground under the object: a person has to take it"},
    {Lower, EndOfReach, TakeOver,
     "a joint is near its limit, it cannot be lowered on: a person has to take it"},
    {Lower, Blocked, Held, kHit},
    {Lower, Declined, Held, kDeclined},
    {Lower, Interrupted, Held, kInterrupted},
    {Lower, DeviceLost, Held, kLost},
    {Lower, TimeOut, Held, "timeout: not lowered"},

    {TakeOver, Supported, Release, "a person bears the object"},
    {TakeOver, PersonHolds, Release, "a person holds the object, as the operator says"},
    {TakeOver, Declined, Held, kDeclined},
    {TakeOver, Interrupted, Held, kInterrupted},
    {TakeOver, DeviceLost, Held, kLost},
    {TakeOver, TimeOut, Held, "timeout: nobody took the object"},

    {Release, Obstructed, Release, "the hand did not open: free the fingers, then it is tried again"},
    {Release, HandOpened, DrawBack, "the hand is open"},
    {Release, Declined, Held, kDeclined},
    {Release, Interrupted, Held, kInterrupted},
    {Release, DeviceLost, Held, kLost},
    {Release, TimeOut, Held, "the hand did not open: the arm holds"},

    {DrawBack, Obstructed, DrawBack, kMet},
    {DrawBack, Clear, Home, "the hand is clear of the object"},
    {DrawBack, Blocked, Held, kHit},
    {DrawBack, Declined, Held, kDeclined},
    {DrawBack, Interrupted, Held, kInterrupted},
    {DrawBack, DeviceLost, Held, kLost},
    {DrawBack, TimeOut, Held, "timeout: the hand was not drawn back"},

    {Home, Obstructed, Home, kMet},
    {Home, RecoveryEvent::AtHome, Done, "the arm is at home"},
    {Home, Blocked, Held, kHit},
    {Home, Declined, Held, kDeclined},
    {Home, Interrupted, Held, kInterrupted},
    {Home, DeviceLost, Held, kLost},
    {Home, TimeOut, Held, "timeout: the arm did not reach home"},
});

}  // namespace

std::span<const RecoveryRule> recovery_rules() {
  return kRules;
}

std::optional<RecoveryRule> next(RecoveryStep now, RecoveryEvent event) {
  const auto rule = std::find_if(kRules.begin(), kRules.end(),
                                 [&](const RecoveryRule& r) { return r.from == now && r.on == event; });
  if (rule == kRules.end()) return std::nullopt;
  return *rule;
}

std::string_view word(RecoveryStep step) {
  constexpr std::array<std::string_view, kRecoverySteps> kWords{"assess",    "lower", "take-over", "release",
                                                                "draw-back", "home",  "done",      "held"};
  return kWords[static_cast<std::size_t>(step)];
}

std::string_view word(RecoveryEvent event) {
  constexpr std::array<std::string_view, kRecoveryEvents> kWords{
      "hand holds", "hand open",    "at home",     "hand unknown", "supported",  "person holds",
      "no ground",  "end of reach", "hand opened", "clear",        "obstructed", "blocked",
      "declined",   "interrupted",  "device lost", "time out"};
  return kWords[static_cast<std::size_t>(event)];
}

bool is_end(RecoveryStep step) {
  return step == Done || step == Held;
}

}  // namespace colift::control
