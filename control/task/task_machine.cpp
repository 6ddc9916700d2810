#include "control/task/task_machine.hpp"

#include <algorithm>
#include <array>

namespace colift::control {

namespace {

using enum Task;
using enum Event;

// reasons that several states share
constexpr std::string_view kArmGone = "the arm does not answer or reports a fault; it has stopped by itself";
constexpr std::string_view kUnfit = "the hand may not grip now";
constexpr std::string_view kHoldsBadly =
    "the hand may not hold on for long: holds, the grip stays closed; lower the object on request";
constexpr std::string_view kHandGone = "the hand does not answer; its fingers stay where they are";
constexpr std::string_view kAsked = "interrupted before the arm set out";
constexpr std::string_view kAskedInTransit = "interrupted; the arm comes to rest and holds";
constexpr std::string_view kAskedLoaded = "interrupted; the arm holds and the grip stays closed";
constexpr std::string_view kPulled =
    "the object is pulled with more force than allowed; holds and keeps the grip";
constexpr std::string_view kHit = "met something on the way; holds, and goes back only on request";
constexpr std::string_view kFell = "the load vanished from the hand; holds";
constexpr std::string_view kReachEnds =
    "a joint has come near its limit: holds, the grip stays closed; lower the object on request";
constexpr std::string_view kAlone =
    "the partner let go while the object was carried; holds, the grip stays closed";

constexpr auto kRules = std::to_array<Rule>({
    // looking: nothing has moved yet
    {Observe, SceneKnown, AwaitPartner, "there is something to carry, and places to grasp it"},
    {Observe, NothingToCarry, Refused, "nothing that could be carried was seen"},
    {Observe, CameraOff, Refused, "what is seen does not fit the robot"},
    {Observe, TimeOut, Refused, "the camera gave no usable picture in time"},
    {Observe, ArmLost, Stopped, kArmGone},
    {Observe, HandLost, Stopped, kHandGone},
    {Observe, Interrupted, Refused, kAsked},

    {AwaitPartner, PartnerGrasped, Decide, "the partner holds the object"},
    {AwaitPartner, NobodyCame, Refused, "nobody took hold of the object"},
    {AwaitPartner, TimeOut, Refused, "waited long enough for a partner"},
    {AwaitPartner, ArmLost, Stopped, kArmGone},
    {AwaitPartner, HandLost, Stopped, kHandGone},
    {AwaitPartner, HandUnfit, Refused, kUnfit},
    {AwaitPartner, Interrupted, Refused, kAsked},

    {Decide, GraspChosen, Plan, "a reachable grasp shares the load as wished"},
    {Decide, NoGraspFits, Refused, "no grasp fits"},
    {Decide, PartnerAsked, AwaitPartner, "no grasp fits: asks the partner to take hold elsewhere"},
    {Decide, PartnerMoved, AwaitPartner, "the partner's grasp moved before it was decided"},
    {Decide, PartnerLetGo, AwaitPartner, "the partner let go before it was decided"},
    {Decide, CameraLost, AwaitPartner, "the camera is gone: waits until it sees again"},
    {Decide, TimeOut, Refused, "the decision took too long"},
    {Decide, ArmLost, Stopped, kArmGone},
    {Decide, HandLost, Stopped, kHandGone},
    {Decide, HandUnfit, Refused, kUnfit},
    {Decide, Interrupted, Refused, kAsked},

    {Plan, PlanReady, Approach, "there is a way to the grasp that touches nothing"},
    {Plan, NoPath, Refused, "no way leads to the grasp"},
    {Plan, PartnerMoved, AwaitPartner, "the partner's grasp moved while the way was planned"},
    {Plan, PartnerLetGo, AwaitPartner, "the partner let go while the way was planned"},
    {Plan, CameraLost, AwaitPartner, "the camera is gone: waits until it sees again, then plans anew"},
    {Plan, TimeOut, Refused, "planning took too long"},
    {Plan, ArmLost, Stopped, kArmGone},
    {Plan, HandLost, Stopped, kHandGone},
    {Plan, HandUnfit, Refused, kUnfit},
    {Plan, Interrupted, Refused, kAsked},

    // on the way, hand open
    {Approach, Arrived, Close, "the hand is around the grasp"},
    {Approach, PartnerMoved, BackOff, "the partner moved: the grasp no longer shares the load as wished"},
    {Approach, PartnerLetGo, BackOff, "the partner let go before the hand was there"},
    {Approach, CameraLost, Halt, "cannot see whether the way is free: stands still"},
    {Approach, Blocked, Stopped, kHit},
    {Approach, TimeOut, Stopped, "the arm did not arrive in time; holds"},
    {Approach, ArmLost, Stopped, kArmGone},
    {Approach, HandLost, Stopped, kHandGone},
    {Approach, HandUnfit, BackOff, "the hand may not grip now: goes back"},
    {Approach, Interrupted, Stopped, kAskedInTransit},

    {Halt, CameraBack, BackOff, "sees again: goes back, then looks and plans anew"},
    {Halt, Blocked, Stopped, kHit},
    {Halt, TimeOut, Stopped, "the camera did not come back; holds"},
    {Halt, ArmLost, Stopped, kArmGone},
    {Halt, HandLost, Stopped, kHandGone},
    {Halt, Interrupted, Stopped, kAskedInTransit},

    {BackOff, BackHome, AwaitPartner, "back home: waits for a grasp of the partner again"},
    {BackOff, BackInVain, Aborted, "back home without the goal; tried often enough"},
    {BackOff, CameraLost, Halt, "cannot see whether the way is free: stands still"},
    {BackOff, Blocked, Stopped, kHit},
    {BackOff, TimeOut, Stopped, "did not get back home in time; holds"},
    {BackOff, ArmLost, Stopped, kArmGone},
    {BackOff, HandLost, Stopped, kHandGone},
    {BackOff, Interrupted, Stopped, kAskedInTransit},

    // the hand is at the object, which stands on the ground: only Release opens it
    {Close, HandHeld, Verify, "every finger is held by contact"},
    {Close, HandEmpty, Release, "the hand closed on nothing: opens it again"},
    {Close, PartnerLetGo, Release,
     "the partner let go before the lift: opens, the object stands on the ground"},
    {Close, Blocked, Stopped, kPulled},
    {Close, TimeOut, Release, "the hand did not finish closing: opens it again"},
    {Close, ArmLost, Stopped, kArmGone},
    {Close, HandLost, Stopped, kHandGone},
    {Close, FingerLost, Release,
     "one part of the hand does not answer: opens the others, the object stands on the ground"},
    {Close, Interrupted, Stopped, kAskedLoaded},

    {Verify, GripGood, AwaitReady, "the grip is as wide and as firm as planned"},
    {Verify, GripBad, Release, "the grip is not good enough to lift: opens, the object stands on the ground"},
    {Verify, HandEmpty, Release, "the grip is lost: opens, the object stands on the ground"},
    {Verify, PartnerLetGo, Release,
     "the partner let go before the lift: opens, the object stands on the ground"},
    {Verify, Blocked, Stopped, kPulled},
    {Verify, TimeOut, Release,
     "the grip could not be checked in time: opens, the object stands on the ground"},
    {Verify, ArmLost, Stopped, kArmGone},
    {Verify, HandLost, Stopped, kHandGone},
    {Verify, Interrupted, Stopped, kAskedLoaded},

    {AwaitReady, PartnerReady, Lift, "the partner holds and is at rest"},
    {AwaitReady, TestDue, TestLift, "the partner holds and is at rest: first a little, slowly"},
    {AwaitReady, PartnerLetGo, Release,
     "the partner let go before the lift: opens, the object stands on the ground"},
    {AwaitReady, HandEmpty, Release, "the grip is lost: opens, the object stands on the ground"},
    {AwaitReady, GripBad, Release,
     "the grip is not good enough to lift: opens, the object stands on the ground"},
    {AwaitReady, Blocked, Stopped, kPulled},
    {AwaitReady, TimeOut, Release, "the partner was never ready: opens, the object stands on the ground"},
    {AwaitReady, ArmLost, Stopped, kArmGone},
    {AwaitReady, HandLost, Stopped, kHandGone},
    {AwaitReady, Interrupted, Stopped, kAskedLoaded},

    // some millimetres, as slowly as it takes to see the object turn
    {TestLift, HangsLevel, Lift, "the object hangs level: lifts on"},
    {TestLift, HangsAskew, Lower, "the object does not hang level: sets it down, takes hold elsewhere"},
    {TestLift, PartnerReady, Lift, "the partner lifts by himself"},
    {TestLift, CameraLost, Lower, "the camera is gone, nobody sees how the object hangs: sets it down"},
    {TestLift, LimitReached, Lower, "a limit of tilt, slip or load was reached: sets the object down"},
    {TestLift, EndOfReach, Stopped, kReachEnds},
    {TestLift, TimeOut, Lower, "the test lift took too long: sets the object down"},
    {TestLift, PartnerLetGo, Stopped, kAlone},
    {TestLift, HandEmpty, Stopped, kFell},
    {TestLift, Blocked, Stopped, kPulled},
    {TestLift, ArmLost, Stopped, kArmGone},
    {TestLift, HandLost, Stopped, kHandGone},
    {TestLift, HandUnfit, Stopped, kHoldsBadly},
    {TestLift, Interrupted, Stopped, kAskedLoaded},

    // the object is in the air
    {Lift, AtHeight, Hold, "the object is at its height"},
    {Lift, LimitReached, Lower, "a limit of tilt, slip or load was reached: sets the object down"},
    {Lift, EndOfReach, Stopped, kReachEnds},
    {Lift, TimeOut, Lower, "the height was not reached in time: sets the object down"},
    {Lift, PartnerLetGo, Stopped, kAlone},
    {Lift, HandEmpty, Stopped, kFell},
    {Lift, Blocked, Stopped, kPulled},
    {Lift, ArmLost, Stopped, kArmGone},
    {Lift, HandLost, Stopped, kHandGone},
    {Lift, HandUnfit, Stopped, kHoldsBadly},
    {Lift, Interrupted, Stopped, kAskedLoaded},

    {Hold, HoldOver, Lower, "held as long as wished"},
    {Hold, LimitReached, Lower, "a limit of tilt, slip or load was reached: sets the object down"},
    {Hold, EndOfReach, Stopped, kReachEnds},
    {Hold, TimeOut, Lower, "held long enough: sets the object down"},
    {Hold, PartnerLetGo, Stopped, kAlone},
    {Hold, HandEmpty, Stopped, kFell},
    {Hold, Blocked, Stopped, kPulled},
    {Hold, ArmLost, Stopped, kArmGone},
    {Hold, HandLost, Stopped, kHandGone},
    {Hold, HandUnfit, Stopped, kHoldsBadly},
    {Hold, Interrupted, Stopped, kAskedLoaded},

    {Lower, OnGround, Release, "the object stands on the ground again"},
    {Lower, EndOfReach, Stopped, kReachEnds},
    {Lower, TimeOut, Stopped, "found no ground under the object; holds, the grip stays closed"},
    {Lower, PartnerLetGo, Stopped, kAlone},
    {Lower, HandEmpty, Stopped, kFell},
    {Lower, Blocked, Stopped, kPulled},
    {Lower, ArmLost, Stopped, kArmGone},
    {Lower, HandLost, Stopped, kHandGone},
    {Lower, Interrupted, Stopped, kAskedLoaded},

    // away from it
    {Release, HandOpen, Retreat, "the hand is open"},
    {Release, TimeOut, Stopped, "the hand did not open; holds"},
    {Release, ArmLost, Stopped, kArmGone},
    {Release, HandLost, Stopped, kHandGone},
    {Release, Interrupted, Stopped, kAskedInTransit},

    {Retreat, BackHome, Done, "lifted, set down, released, and back home"},
    {Retreat, TryAgain, AwaitPartner, "back home after a grip that failed: tries again"},
    {Retreat, BackInVain, Aborted, "back home without the goal"},
    {Retreat, Blocked, Stopped, kHit},
    {Retreat, TimeOut, Stopped, "did not get back home in time; holds"},
    {Retreat, ArmLost, Stopped, kArmGone},
    {Retreat, HandLost, Stopped, kHandGone},
    {Retreat, Interrupted, Stopped, kAskedInTransit},
});

struct TaskWords {
  std::string_view name, waits_for;
};

constexpr TaskWords words(Task task) {
  switch (task) {
    case Observe:
      return {"observe", "a picture of the scene"};
    case AwaitPartner:
      return {"await-partner", "a partner who takes hold of the object"};
    case Decide:
      return {"decide", "the choice of a grasp"};
    case Plan:
      return {"plan", "a free way to the grasp"};
    case Approach:
      return {"approach", "the arm to arrive at the grasp"};
    case Close:
      return {"close", "the fingers to meet the object"};
    case Verify:
      return {"verify", "the grip to be checked"};
    case AwaitReady:
      return {"await-ready", "the partner to hold still"};
    case TestLift:
      return {"test-lift", "the object to show how it hangs"};
    case Lift:
      return {"lift", "the object to reach its height"};
    case Hold:
      return {"hold", "the end of the holding time"};
    case Lower:
      return {"lower", "the object to stand on the ground"};
    case Release:
      return {"release", "the hand to open"};
    case Retreat:
      return {"retreat", "the arm to be back home"};
    case BackOff:
      return {"back-off", "the arm to be back home"};
    case Halt:
      return {"halt", "the camera to see again"};
    case Done:
      return {"done", "nothing: the job is done"};
    case Refused:
      return {"refused", "nothing: the job was refused"};
    case Aborted:
      return {"aborted", "nothing: the job was given up"};
    case Stopped:
      return {"stopped", "a person to decide"};
  }
  return {"", ""};
}

}  // namespace

std::span<const Rule> rules() {
  return kRules;
}

std::optional<Rule> next(Task now, Event event) {
  const auto rule = std::find_if(kRules.begin(), kRules.end(),
                                 [&](const Rule& r) { return r.from == now && r.on == event; });
  if (rule == kRules.end()) return std::nullopt;
  return *rule;
}

std::string_view word(Task task) {
  return words(task).name;
}

std::string_view waits_for(Task task) {
  return words(task).waits_for;
}

std::string_view word(Event event) {
  switch (event) {
    case SceneKnown:
      return "scene known";
    case NothingToCarry:
      return "nothing to carry";
    case CameraOff:
      return "camera off";
    case PartnerGrasped:
      return "partner grasped";
    case PartnerMoved:
      return "partner moved";
    case PartnerLetGo:
      return "partner let go";
    case NobodyCame:
      return "nobody came";
    case GraspChosen:
      return "grasp chosen";
    case NoGraspFits:
      return "no grasp fits";
    case PartnerAsked:
      return "partner asked";
    case PlanReady:
      return "plan ready";
    case NoPath:
      return "no way";
    case Arrived:
      return "arrived";
    case Blocked:
      return "blocked";
    case HandHeld:
      return "hand held";
    case HandEmpty:
      return "hand empty";
    case GripGood:
      return "grip good";
    case GripBad:
      return "grip bad";
    case PartnerReady:
      return "partner ready";
    case TestDue:
      return "test due";
    case HangsLevel:
      return "hangs level";
    case HangsAskew:
      return "hangs askew";
    case AtHeight:
      return "at height";
    case LimitReached:
      return "limit reached";
    case EndOfReach:
      return "end of reach";
    case HoldOver:
      return "hold over";
    case OnGround:
      return "on ground";
    case HandOpen:
      return "hand open";
    case BackHome:
      return "back home";
    case TryAgain:
      return "try again";
    case BackInVain:
      return "back in vain";
    case CameraLost:
      return "camera lost";
    case CameraBack:
      return "camera back";
    case ArmLost:
      return "arm lost";
    case HandUnfit:
      return "hand unfit";
    case HandLost:
      return "hand lost";
    case FingerLost:
      return "finger lost";
    case Interrupted:
      return "interrupted";
    case TimeOut:
      return "time out";
  }
  return "";
}

bool is_end(Task task) {
  return task == Done || task == Refused || task == Aborted || task == Stopped;
}

bool is_loaded(Task task) {
  return task == Close || task == Verify || task == AwaitReady || task == TestLift || task == Lift ||
         task == Hold || task == Lower || task == Release;
}

bool is_moving(Task task) {
  return task == Approach || task == TestLift || task == Lift || task == Lower || task == Retreat ||
         task == BackOff;
}

}  // namespace colift::control
