#include "control/task/machine/task_machine.hpp"

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
    "the hand may not hold for long: holds, the grip stays closed; lower the object on request";
constexpr std::string_view kHandGone = "the hand does not answer; its fingers stay where they are";
constexpr std::string_view kAsked = "interrupted before the arm moved";
constexpr std::string_view kAskedInTransit = "interrupted; the arm comes to rest and holds";
constexpr std::string_view kAskedLoaded = "interrupted; the arm holds and the grip stays closed";
constexpr std::string_view kPushed = "unexpected force; stops and yields, the grip stays closed";
constexpr std::string_view kPushedAtGrasp =
    "unexpected force; stops, yields and opens the hand: the object is on the ground";
constexpr std::string_view kHit = "unexpected contact; stops and yields, returns only on request";
constexpr std::string_view kPushedAtRest = "unexpected force on the arm at rest; yields";
constexpr std::string_view kFell = "load lost from the hand; holds";
constexpr std::string_view kReachEnds =
    "joint near its limit: holds, the grip stays closed; lower the object on request";
constexpr std::string_view kAlone =
    "the partner let go while the object was carried; holds, the grip stays closed, asks him to grasp again";
constexpr std::string_view kPulled =
    "sudden pull at the carried object; holds, asks the partner to stand still";
constexpr std::string_view kStaysNear = "somebody stayed near the arm for too long; holds";
constexpr std::string_view kStaysNearLoaded =
    "somebody stayed near the arm for too long; holds, the grip stays closed; lower the object on request";
constexpr std::string_view kNotConfirmed = "timeout: nobody confirmed that the arm may continue; holds";
constexpr std::string_view kNotConfirmedLoaded =
    "timeout: nobody confirmed that the arm may continue; holds, the grip stays closed; lower the object on "
    "request";
constexpr std::string_view kStalled =
    "the job's thread was stalled while the arm moved; holds, the grip stays as it is";

constexpr auto kRules = std::to_array<Rule>({
    // looking: nothing has moved yet
    {Observe, SceneKnown, AwaitPartner, "an object to carry and feasible grasps were found"},
    {Observe, NothingToCarry, Refused, "no object to carry was found"},
    {Observe, CameraOff, Refused, "the camera image does not match the robot model: check the calibration"},
    {Observe, TimeOut, Refused, "timeout: no usable camera image"},
    {Observe, Blocked, Yield, kPushedAtRest},
    {Observe, ArmLost, Stopped, kArmGone},
    {Observe, HandLost, Stopped, kHandGone},
    {Observe, Interrupted, Refused, kAsked},

    {AwaitPartner, PartnerGrasped, Decide, "the partner grasps the object"},
    {AwaitPartner, SceneChanged, Observe, "the scene is another one than was seen: looks at it anew"},
    {AwaitPartner, NobodyCame, Refused, "no partner grasped the object"},
    {AwaitPartner, TimeOut, Refused, "timeout: no partner"},
    {AwaitPartner, Blocked, Yield, kPushedAtRest},
    {AwaitPartner, ArmLost, Stopped, kArmGone},
    {AwaitPartner, HandLost, Stopped, kHandGone},
    {AwaitPartner, HandUnfit, Refused, kUnfit},
    {AwaitPartner, Interrupted, Refused, kAsked},

    {Decide, GraspChosen, Plan, "a reachable grasp is chosen"},
    {Decide, NoGraspFits, Refused, "no feasible grasp"},
    {Decide, PartnerAsked, AwaitPartner, "no feasible grasp: asks the partner to grasp elsewhere"},
    {Decide, PartnerMoved, AwaitPartner, "the partner's grasp moved before it was decided"},
    {Decide, PartnerLetGo, AwaitPartner, "the partner let go before it was decided"},
    {Decide, CameraLost, AwaitPartner, "camera lost: waits for it"},
    {Decide, TimeOut, Refused, "timeout: decision"},
    {Decide, Blocked, Yield, kPushedAtRest},
    {Decide, ArmLost, Stopped, kArmGone},
    {Decide, HandLost, Stopped, kHandGone},
    {Decide, HandUnfit, Refused, kUnfit},
    {Decide, Interrupted, Refused, kAsked},

    {Plan, PlanReady, Approach, "collision-free path to the grasp found"},
    {Plan, NoPath, Refused, "no collision-free path to the grasp"},
    {Plan, DryRunOver, Refused, "dry run: a collision-free path was found, nothing was moved"},
    {Plan, PartnerMoved, AwaitPartner, "the partner's grasp moved during planning"},
    {Plan, PartnerLetGo, AwaitPartner, "the partner let go during planning"},
    {Plan, CameraLost, AwaitPartner, "camera lost: waits for it, then plans again"},
    {Plan, TimeOut, Refused, "timeout: planning"},
    {Plan, Blocked, Yield, kPushedAtRest},
    {Plan, ArmLost, Stopped, kArmGone},
    {Plan, HandLost, Stopped, kHandGone},
    {Plan, HandUnfit, Refused, kUnfit},
    {Plan, Interrupted, Refused, kAsked},

    // on the way, hand open
    {Approach, Arrived, Close, "hand at the grasp"},
    {Approach, PartnerMoved, BackOff, "the partner moved: the grasp no longer gives the requested share"},
    {Approach, PartnerLetGo, BackOff, "the partner let go before the hand arrived"},
    {Approach, PathObstructed, BackOff, "the path stays obstructed: returns, then plans another"},
    {Approach, CameraLost, Halt, "camera lost: cannot check the path, stopped"},
    {Approach, TouchedObject, Contact, "the open hand met something at the object; stops and yields"},
    {Approach, Blocked, Yield, kHit},
    {Approach, TimeOut, Stopped, "the arm did not get to the grasp; holds"},
    {Approach, StaysNear, Stopped, kStaysNear},
    {Approach, NotConfirmed, Stopped, kNotConfirmed},
    {Approach, Stalled, Stopped, kStalled},
    {Approach, ArmLost, Stopped, kArmGone},
    {Approach, HandLost, Stopped, kHandGone},
    {Approach, HandUnfit, BackOff, "the hand may not grip now: returns"},
    {Approach, Interrupted, Stopped, kAskedInTransit},

    {Contact, ForceGone, Retreat, "the force is gone: returns"},
    {Contact, Blocked, Yield, kHit},
    {Contact, TimeOut, Stopped, "the arm did not leave what it met; holds"},
    {Contact, ArmLost, Stopped, kArmGone},
    {Contact, HandLost, Stopped, kHandGone},
    {Contact, Interrupted, Stopped, kAskedInTransit},

    {Halt, CameraBack, BackOff, "camera back: returns, then observes and plans again"},
    {Halt, Blocked, Yield, kHit},
    {Halt, TimeOut, Stopped, "timeout: the camera did not come back; holds"},
    {Halt, ArmLost, Stopped, kArmGone},
    {Halt, HandLost, Stopped, kHandGone},
    {Halt, Interrupted, Stopped, kAskedInTransit},

    {BackOff, BackHome, AwaitPartner, "at home: waits for the partner's grasp again"},
    {BackOff, BackInVain, Aborted, "at home without the goal: no attempts left"},
    {BackOff, CameraLost, Halt, "camera lost: cannot check the path, stopped"},
    {BackOff, Blocked, Yield, kHit},
    {BackOff, TimeOut, Stopped, "the arm did not get home; holds"},
    {BackOff, StaysNear, Stopped, kStaysNear},
    {BackOff, NotConfirmed, Stopped, kNotConfirmed},
    {BackOff, Stalled, Stopped, kStalled},
    {BackOff, ArmLost, Stopped, kArmGone},
    {BackOff, HandLost, Stopped, kHandGone},
    {BackOff, Interrupted, Stopped, kAskedInTransit},

    // the hand is at the object, which stands on the ground: Release opens it, and Yield at once
    {Close, HandHeld, Verify, "every finger is in contact"},
    {Close, HandEmpty, Release, "the hand has no grip: opens it again"},
    {Close, PartnerLetGo, Release, "the partner let go before the lift: opens, the object is on the ground"},
    {Close, Blocked, Yield, kPushedAtGrasp},
    {Close, TimeOut, Release, "the hand did not finish closing: opens it again"},
    {Close, ArmLost, Stopped, kArmGone},
    {Close, HandLost, Stopped, kHandGone},
    {Close, FingerLost, Release, "one finger does not answer: opens the others, the object is on the ground"},
    {Close, Interrupted, Stopped, kAskedLoaded},

    {Verify, GripGood, AwaitReady, "the grip has the planned width and force"},
    {Verify, GripBad, Release, "the grip is not good enough to lift: opens, the object is on the ground"},
    {Verify, HandEmpty, Release, "the grip is lost: opens, the object is on the ground"},
    {Verify, PartnerLetGo, Release, "the partner let go before the lift: opens, the object is on the ground"},
    {Verify, Blocked, Yield, kPushedAtGrasp},
    {Verify, TimeOut, Release, "the grip could not be checked in time: opens, the object is on the ground"},
    {Verify, ArmLost, Stopped, kArmGone},
    {Verify, HandLost, Stopped, kHandGone},
    {Verify, Interrupted, Stopped, kAskedLoaded},

    {AwaitReady, PartnerReady, Lift, "the partner holds and is at rest"},
    {AwaitReady, TestDue, TestLift, "the partner holds and is at rest: test lift first"},
    {AwaitReady, PartnerLetGo, Release,
     "the partner let go before the lift: opens, the object is on the ground"},
    {AwaitReady, HandEmpty, Release, "the grip is lost: opens, the object is on the ground"},
    {AwaitReady, GripBad, Release, "the grip is not good enough to lift: opens, the object is on the ground"},
    {AwaitReady, Blocked, Yield, kPushedAtGrasp},
    {AwaitReady, TimeOut, Release, "the partner was never ready: opens, the object is on the ground"},
    {AwaitReady, ArmLost, Stopped, kArmGone},
    {AwaitReady, HandLost, Stopped, kHandGone},
    {AwaitReady, Interrupted, Stopped, kAskedLoaded},

    // some millimetres, as slowly as it takes to see the object turn
    {TestLift, HangsLevel, Lift, "the object is level: lift continues"},
    {TestLift, HangsAskew, Lower, "the object is not level: sets it down, grasps elsewhere"},
    {TestLift, PartnerReady, Lift, "the partner lifts first"},
    {TestLift, CameraLost, Lower, "camera lost, the tilt is not observed: sets the object down"},
    {TestLift, LimitReached, Lower, "a limit of tilt, slip or load was reached: sets the object down"},
    {TestLift, EndOfReach, Stopped, kReachEnds},
    {TestLift, TimeOut, Lower, "the test lift took too long: sets the object down"},
    {TestLift, PartnerLetGo, Pause, kAlone},
    {TestLift, PartnerPulls, Pause, kPulled},
    {TestLift, HandEmpty, Stopped, kFell},
    {TestLift, Blocked, Yield, kPushed},
    {TestLift, StaysNear, Stopped, kStaysNearLoaded},
    {TestLift, NotConfirmed, Stopped, kNotConfirmedLoaded},
    {TestLift, Stalled, Stopped, kStalled},
    {TestLift, ArmLost, Stopped, kArmGone},
    {TestLift, HandLost, Stopped, kHandGone},
    {TestLift, HandUnfit, Stopped, kHoldsBadly},
    {TestLift, Interrupted, Stopped, kAskedLoaded},

    // the object is in the air
    {Lift, AtHeight, Hold, "target height reached"},
    {Lift, LimitReached, Lower, "a limit of tilt, slip or load was reached: sets the object down"},
    {Lift, EndOfReach, Stopped, kReachEnds},
    {Lift, TimeOut, Lower, "the height was not reached in time: sets the object down"},
    {Lift, PartnerLetGo, Pause, kAlone},
    {Lift, PartnerPulls, Pause, kPulled},
    {Lift, HandEmpty, Stopped, kFell},
    {Lift, Blocked, Yield, kPushed},
    {Lift, StaysNear, Stopped, kStaysNearLoaded},
    {Lift, NotConfirmed, Stopped, kNotConfirmedLoaded},
    {Lift, Stalled, Stopped, kStalled},
    {Lift, ArmLost, Stopped, kArmGone},
    {Lift, HandLost, Stopped, kHandGone},
    {Lift, HandUnfit, Stopped, kHoldsBadly},
    {Lift, Interrupted, Stopped, kAskedLoaded},

    {Hold, HoldOver, Lower, "hold time over"},
    {Hold, LimitReached, Lower, "a limit of tilt, slip or load was reached: sets the object down"},
    {Hold, EndOfReach, Stopped, kReachEnds},
    {Hold, TimeOut, Lower, "held long enough: sets the object down"},
    {Hold, PartnerLetGo, Pause, kAlone},
    {Hold, PartnerPulls, Pause, kPulled},
    {Hold, HandEmpty, Stopped, kFell},
    {Hold, Blocked, Yield, kPushed},
    {Hold, ArmLost, Stopped, kArmGone},
    {Hold, HandLost, Stopped, kHandGone},
    {Hold, HandUnfit, Stopped, kHoldsBadly},
    {Hold, Interrupted, Stopped, kAskedLoaded},

    {Lower, OnGround, Release, "the object is on the ground"},
    {Lower, Obstructed, Pause,
     "the object meets something before the ground; holds, the grip stays closed, asks to clear it"},
    {Lower, EndOfReach, Stopped, kReachEnds},
    {Lower, TimeOut, Stopped, "found no ground under the object; holds, the grip stays closed"},
    {Lower, PartnerLetGo, Pause, kAlone},
    {Lower, PartnerPulls, Pause, kPulled},
    {Lower, HandEmpty, Stopped, kFell},
    {Lower, Blocked, Yield, kPushed},
    {Lower, StaysNear, Stopped, kStaysNearLoaded},
    {Lower, NotConfirmed, Stopped, kNotConfirmedLoaded},
    {Lower, Stalled, Stopped, kStalled},
    {Lower, ArmLost, Stopped, kArmGone},
    {Lower, HandLost, Stopped, kHandGone},
    {Lower, Interrupted, Stopped, kAskedLoaded},

    // in the air on the spot: nothing lowers it by itself, a person may be under it, unless it stands already
    {Pause, PartnerBack, Lift, "the partner holds again: the lift continues"},
    {Pause, HoldOver, Lower, "the partner holds again, or the object meets the ground: sets it down"},
    {Pause, OnGround, Lower, "the object stands: nothing is left to carry"},
    {Pause, LowerConfirmed, Lower, "a person confirmed lowering: sets the object down"},
    {Pause, TimeOut, Stopped, "timeout: nobody keeps hold of the object; holds, the grip stays closed"},
    {Pause, HandEmpty, Stopped, kFell},
    {Pause, Blocked, Yield, kPushed},
    {Pause, ArmLost, Stopped, kArmGone},
    {Pause, HandLost, Stopped, kHandGone},
    {Pause, HandUnfit, Stopped, kHoldsBadly},
    {Pause, Interrupted, Stopped, kAskedLoaded},

    // soft, until the force is gone
    {Yield, TimeOut, Stopped, "yielded to unexpected force; holds, a closed grip stays closed"},
    {Yield, ArmLost, Stopped, kArmGone},
    {Yield, HandLost, Stopped, kHandGone},
    {Yield, Interrupted, Stopped, kAskedLoaded},

    // away from it
    {Release, HandOpen, Retreat, "the hand is open"},
    {Release, StillLoaded, Stopped, "no evidence that the object is supported: the hand stays closed"},
    {Release, Blocked, Yield, kPushed},
    {Release, TimeOut, Stopped, "the hand did not open; holds"},
    {Release, StaysNear, Stopped, kStaysNearLoaded},
    {Release, NotConfirmed, Stopped, kNotConfirmedLoaded},
    {Release, ArmLost, Stopped, kArmGone},
    {Release, HandLost, Stopped, kHandGone},
    {Release, Interrupted, Stopped, kAskedInTransit},

    {Retreat, BackHome, Done, "lifted, set down, released, and back home"},
    {Retreat, TryAgain, AwaitPartner, "back home after a grasp that failed: tries again"},
    {Retreat, BackInVain, Aborted, "at home without the goal"},
    {Retreat, TouchedObject, Contact, "the open hand still met the object; stops and yields"},
    {Retreat, Blocked, Yield, kHit},
    {Retreat, TimeOut, Stopped, "the arm did not get home; holds"},
    {Retreat, StaysNear, Stopped, kStaysNear},
    {Retreat, NotConfirmed, Stopped, kNotConfirmed},
    {Retreat, Stalled, Stopped, kStalled},
    {Retreat, ArmLost, Stopped, kArmGone},
    {Retreat, HandLost, Stopped, kHandGone},
    {Retreat, Interrupted, Stopped, kAskedInTransit},
});

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

bool is_end(Task task) {
  return task == Done || task == Refused || task == Aborted || task == Stopped;
}

bool is_loaded(Task task) {
  return task == Close || task == Verify || task == AwaitReady || task == TestLift || task == Lift ||
         task == Hold || task == Lower || task == Pause || task == Yield || task == Release;
}

bool is_moving(Task task) {
  return task == Approach || task == TestLift || task == Lift || task == Lower || task == Retreat ||
         task == BackOff;
}

}  // namespace colift::control
