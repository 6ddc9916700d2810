// The names of states and events, and what a state waits for, as screen, log and documents show them.

#include "control/task/machine/task_machine.hpp"

namespace colift::control {

namespace {

using enum Task;
using enum Event;

struct TaskWords {
  std::string_view name, waits_for;
};

constexpr TaskWords words(Task task) {
  switch (task) {
    case Observe:
      return {"observe", "a picture of the scene"};
    case AwaitPartner:
      return {"await-partner", "a partner who grasps the object"};
    case Decide:
      return {"decide", "the choice of a grasp"};
    case Plan:
      return {"plan", "a collision-free path to the grasp"};
    case Approach:
      return {"approach", "the arm to arrive at the grasp"};
    case Contact:
      return {"contact", "the force on the open hand to end"};
    case Close:
      return {"close", "the fingers to meet the object"};
    case Verify:
      return {"verify", "the grip to be checked"};
    case AwaitReady:
      return {"await-ready", "the partner to hold still"};
    case TestLift:
      return {"test-lift", "the measurement of tilt and load"};
    case Lift:
      return {"lift", "the object to reach its height"};
    case Hold:
      return {"hold", "the end of the holding time"};
    case Lower:
      return {"lower", "the object to reach the ground"};
    case Pause:
      return {"pause", "the partner to grasp again, or a person to confirm lowering"};
    case Yield:
      return {"yield", "the force on the arm to end"};
    case Release:
      return {"release", "the hand to open"};
    case Retreat:
      return {"retreat", "the arm to reach home"};
    case BackOff:
      return {"back-off", "the arm to reach home"};
    case Halt:
      return {"halt", "the camera to return"};
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
    case SceneChanged:
      return "scene changed";
    case CameraOff:
      return "camera off";
    case PartnerGrasped:
      return "partner grasped";
    case PartnerMoved:
      return "partner moved";
    case PartnerLetGo:
      return "partner let go";
    case PartnerPulls:
      return "partner pulls";
    case NobodyCame:
      return "nobody came";
    case GraspChosen:
      return "grasp chosen";
    case NoGraspFits:
      return "no feasible grasp";
    case PartnerAsked:
      return "partner asked";
    case PlanReady:
      return "plan ready";
    case NoPath:
      return "no path";
    case DryRunOver:
      return "dry run over";
    case Arrived:
      return "arrived";
    case PathObstructed:
      return "path obstructed";
    case StaysNear:
      return "stays near";
    case NotConfirmed:
      return "not confirmed";
    case TouchedObject:
      return "touched object";
    case ForceGone:
      return "force gone";
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
    case PartnerBack:
      return "partner back";
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
    case LowerConfirmed:
      return "lowering confirmed";
    case OnGround:
      return "on ground";
    case Obstructed:
      return "obstructed";
    case StillLoaded:
      return "still loaded";
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
    case Stalled:
      return "stalled";
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

}  // namespace colift::control
