#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace colift::control {

/// What the robot is doing. The words are those of the screen, the log and the JSON: word(Task).
enum class Task {
  Observe,       ///< Looks at the scene: ground, target, candidates, map.
  AwaitPartner,  ///< Waits until somebody holds the object.
  Decide,        ///< Which grasp, and is it reachable.
  Plan,          ///< The way there.
  Approach,      ///< Moves to pre-grasp, then straight to the grasp.
  Contact,       ///< Stopped, soft, by what the open hand met at the object; nobody is near.
  Close,         ///< Closes the hand.
  Verify,        ///< Checks the grip: width, strain, nothing slips.
  AwaitReady,    ///< Waits until the partner still holds and is at rest.
  TestLift,      ///< Raises slowly by some millimetres, to learn where the object is heavy.
  Lift,
  Hold,
  Lower,
  Pause,  ///< Holds a raised object on the spot: the partner let go, or something is in its way; he is asked.
  Yield,  ///< Stopped by unexpected force, soft: whoever pushes can push free. With or without an object.
  Release,  ///< Opens the hand: the only state that does so while it is loaded.
  Retreat,  ///< Away from the object and home, after release.
  BackOff,  ///< Stops and goes back the way it came, hand empty, because the grasp is off.
  Halt,     ///< Stands still on its way, hand empty, until the camera sees again.
  Done,     ///< End: everything went as wished.
  Refused,  ///< End: nothing was moved, or everything is back home, and there is a reason.
  Aborted,  ///< End: back home, safely, without the goal.
  Stopped,  ///< End: holds its position, grip kept; a person has to decide.
};

enum class Event {
  SceneKnown,
  NothingToCarry,
  SceneChanged,  ///< SceneChanged: what stood there was carried off, and nobody is in view.
  CameraOff,     ///< CameraOff: ground or arm are seen where they cannot be; the calibration does not fit.
  PartnerGrasped,
  PartnerMoved,
  PartnerLetGo,
  PartnerPulls,  ///< PartnerPulls: a sudden sideways force through the object that he holds.
  NobodyCame,
  GraspChosen,
  NoGraspFits,
  PartnerAsked,  ///< PartnerAsked: no grasp fits while he holds there; he was asked to grasp elsewhere.
  PlanReady,
  NoPath,
  DryRunOver,  ///< DryRunOver: a path was found, and nothing is to be moved.
  Arrived,
  PathObstructed,  ///< PathObstructed: somebody or something stays in the path; another one is to be planned.
  StaysNear,       ///< StaysNear: the arm has waited for somebody for as long as it waits for anybody.
  NotConfirmed,    ///< NotConfirmed: nobody confirmed that an arm which had stopped may continue.
  TouchedObject,   ///< TouchedObject: the open hand met something at the object, and nobody is near.
  ForceGone,       ///< ForceGone: what the arm met does not push any more.
  Blocked,         ///< Blocked: unexpected contact, or the arm does not follow.
  HandHeld,
  HandEmpty,
  GripGood,
  GripBad,
  PartnerReady,
  PartnerBack,  ///< PartnerBack: he let go of a raised object and holds it again.
  TestDue,      ///< TestDue: he is ready, and what the object weighs where is not known yet.
  HangsLevel,
  HangsAskew,
  AtHeight,
  LimitReached,  ///< LimitReached: tilt, slip, force or mass beyond its limit.
  EndOfReach,    ///< EndOfReach: a joint would come too near to its limit; the arm has slowed to rest.
  HoldOver,
  LowerConfirmed,  ///< LowerConfirmed: a person confirmed that a paused object may be set down.
  OnGround,
  Obstructed,   ///< Obstructed: the object met something before the ground.
  StillLoaded,  ///< StillLoaded: no evidence that the object is supported, so the hand stays closed.
  HandOpen,
  BackHome,
  TryAgain,    ///< TryAgain: back home after a grasp that failed, and attempts are left.
  BackInVain,  ///< BackInVain: back home without the goal, and no attempts left.
  CameraLost,
  CameraBack,
  ArmLost,
  HandLost,
  FingerLost,  ///< FingerLost: one puck does not answer, the others obey.
  Stalled,     ///< The job's own thread did not run for too long: the arm stopped by itself meanwhile.
  HandUnfit,   ///< It works, but may not grip now, or not hold on for long.
  Interrupted,
  TimeOut,
};

/// One row of the table: in state `from`, event `on` leads to state `to`.
struct Rule {
  Task from;
  Event on;
  Task to;
  std::string_view reason;
};

inline constexpr int kTasks = static_cast<int>(Task::Stopped) + 1;
inline constexpr int kEvents = static_cast<int>(Event::TimeOut) + 1;

/// The whole machine, as a table that a person can read from top to bottom. No rule leads to its own state:
/// what changes nothing (a camera lost while the object is carried, led by force) is a note, not a rule.
[[nodiscard]] std::span<const Rule> rules();

/// The rule for an event in a state; nullopt: the event means nothing there. Pure: no clock, no device, no
/// log.
[[nodiscard]] std::optional<Rule> next(Task now, Event event);

[[nodiscard]] std::string_view word(Task task);
[[nodiscard]] std::string_view word(Event event);
/// What the state waits for, in words for a person.
[[nodiscard]] std::string_view waits_for(Task task);
[[nodiscard]] bool is_end(Task task);
/// From first finger contact to the end of Release.
[[nodiscard]] bool is_loaded(Task task);
/// The arm is commanded to move.
[[nodiscard]] bool is_moving(Task task);

/// The table as a Graphviz drawing, for `colift check --graph`.
[[nodiscard]] std::string graph();

}  // namespace colift::control
