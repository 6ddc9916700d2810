#include "control/task/runner/task_runner.hpp"

#include "control/task/run_job.hpp"
#include "control/task/runner/expected_force.hpp"

#include <fmt/format.h>

#include <cmath>
#include <utility>
#include <vector>

namespace colift::control {
namespace {

using namespace std::chrono_literals;

constexpr hal::Duration kReportEvery = 33ms;  // the camera's frame period: nothing new is seen sooner

/// How long the object was held at its height (s): shorter than asked where the partner lowered first.
double held_s(const std::vector<StateChange>& states) {
  double sum_s = 0.0;
  for (std::size_t i = 0; i + 1 < states.size(); ++i)
    if (states[i].state == Task::Hold) sum_s += hal::seconds(states[i + 1].at - states[i].at);
  return sum_s;
}

/// Whether the job goes home without its goal from here on.
bool is_failure(Task from, Event event, Task to) {
  return event == Event::LimitReached || event == Event::HangsAskew ||
         (from == Task::TestLift && to == Task::Lower) || (to == Task::Release && event != Event::OnGround) ||
         to == Task::BackOff || (from == Task::Approach && to == Task::Contact);
}

}  // namespace

TaskRunner::TaskRunner(hal::Robot& robot, const RigView& rig, const Config& config, const JobOptions& options,
                       const hal::Clock& stopwatch)
    : c_(robot, rig, config, options, stopwatch) {}

hal::Result<RunRecord> TaskRunner::run(const JobHooks& hooks) {
  if (auto started = start(); !started) return tl::unexpected(started.error());
  if (hooks.started) hooks.started();
  while (cycle(hooks)) {
  }
  return finish();
}

hal::Result<> TaskRunner::start() {
  if (auto started = start_devices(); !started) return started;
  c_.record.realtime = c_.arm.realtime();
  for (const std::string& words : c_.robot.hand->realtime())
    if (words.starts_with("scheduling")) c_.record.realtime.push_back("hand's thread: " + words);
  c_.began = c_.now = c_.since = c_.robot.clock->now();
  wall_start_ = c_.stopwatch.now();
  hand_.start();
  camera_.start();
  speed_.start();
  separation_.start();
  c_.readings.arm = c_.arm.view().state;
  retreat_phase_.set_home(c_.readings.arm.q_commanded_rad);
  reason_ = "observing the scene";
  c_.record.states.push_back({hal::Timestamp(0), c_.state, reason_});
  return {};
}

hal::Result<> TaskRunner::start_devices() {
  // a hand takes seconds to wake and to find its stops, and the arm's controller asks for answers all the
  // time: an arm with a thread of its own comes first, one that is served between the others' work comes last
  const bool arm_first = c_.options.drive == Drive::Thread;
  const auto start_arm = [this]() -> hal::Result<> {
    if (auto ok = c_.robot.arm->configure(); !ok) return ok;
    return c_.arm.start();  // activates it, in the thread that answers its cycles
  };
  if (arm_first)
    if (auto started = start_arm(); !started) return started;
  std::vector<hal::Device*> others{c_.robot.camera.get()};
  for (const auto& camera : c_.robot.more_cameras) others.push_back(camera.get());
  others.push_back(c_.robot.hand.get());
  for (hal::Device* device : others)
    if (auto ok = device->configure(); !ok) return ok;
  for (hal::Device* device : others)
    if (auto ok = device->activate(); !ok) return ok;
  return arm_first ? hal::Result<>{} : start_arm();
}

bool TaskRunner::cycle(const JobHooks& hooks) {
  read_devices();
  hear_operator(hooks);
  // faults first; where one means nothing, the work continues
  const auto fault = emergency();
  if (fault && next(c_.state, fault->event)) {
    apply(as_touch(*fault), hooks);
  } else if (waits_for_arm()) {
    c_.doing = "the arm is stopped until its controller accepts commands again";
  } else if (stall_.waiting()) {
    c_.doing = "the arm is stopped until the job's thread runs in time again";
  } else {
    if (arm_.take_restart() | stall_.take_recovery()) resume_after_restart();
    if (const auto event = work()) apply(as_touch(*event), hooks);
    if (const auto aside = partner_phase_.take_aside(); aside && hooks.asked)
      hooks.asked({std::nullopt, aside});
  }
  c_.arm.end_cycle();
  if (c_.arm.view().refused_commands > 0 && !refusal_noted_ && !is_end(c_.state)) {
    refusal_noted_ = true;
    c_.note_device("arm", c_.arm.view().refusal.str());
  }
  if (hooks.tracked && (c_.tracked.X_WO || c_.tracked.partner_W)) hooks.tracked(c_.tracked);
  if (c_.now - reported_at_ >= kReportEvery) report(hooks);
  c_.record.palm_springs = c_.arm.view().palm_springs;
  c_.record.energy_margin_j = std::fmin(c_.record.energy_margin_j, c_.arm.view().min_energy_j);
  if (hooks.cycle) hooks.cycle(c_.arm.view());
  return !is_end(c_.state);
}

void TaskRunner::read_devices() {
  arm_.read(speed_.reason());
  hand_.read();
  c_.past.add(c_.readings.arm.measured_at, c_.posture());
  camera_.read();
  c_.tracked = {c_.readings.frame_at, {}, {}};
  speed_.update(hand_.warning());
  separation_.update(speed_.image_age_s());
  stall_.read();
}

// asked in every cycle: what he confirmed before anything waited for it is gone
void TaskRunner::hear_operator(const JobHooks& hooks) {
  interrupted_ = hooks.interrupted && hooks.interrupted();
  lower_confirmed_ = hooks.lower_confirmed && hooks.lower_confirmed();
  if (hooks.continue_confirmed && hooks.continue_confirmed()) separation_.confirm();
}

std::optional<TaskEvent> TaskRunner::emergency() const {
  if (interrupted_) return TaskEvent{Event::Interrupted, "asked to end"};
  if (arm_.lost()) return TaskEvent{Event::ArmLost, arm_.fault()};
  if (!stall_.fault().empty()) return TaskEvent{Event::Stalled, stall_.fault()};
  // with nothing held yet the others are opened; later one finger less is a grip that nobody may trust
  if (hand_.lost() && hand_.silent_puck() && next(c_.state, Event::FingerLost))
    return TaskEvent{Event::FingerLost, hand_.fault()};
  if (hand_.lost()) return TaskEvent{Event::HandLost, hand_.fault()};
  if (auto pushed = pushed_event()) return pushed;
  // who confirms has looked, and the camera is not needed for it
  if (c_.state == Task::Pause && lower_confirmed_) return TaskEvent{Event::LowerConfirmed, ""};
  if (c_.readings.camera_lost) return TaskEvent{Event::CameraLost, "the camera gives no picture"};
  if (auto obstructed = separation_.path_obstructed(); obstructed && next(c_.state, obstructed->event))
    return obstructed;
  if (auto too_long = separation_.waited_too_long()) return too_long;
  const hal::HandState& hand = c_.readings.hand;
  if (hand.hot && !is_loaded(c_.state)) return TaskEvent{Event::HandUnfit, hand.warning.str()};
  return std::nullopt;
}

std::optional<TaskEvent> TaskRunner::pushed_event() const {
  const ForceFinding& force = c_.arm.view().force;
  if (!force || !c_.arm.blocked()) return std::nullopt;
  if (c_.state == Task::Contact) return std::nullopt;  // judges that itself
  // a standing object under a hand that was lowered too far: opening ends that, and the arm is soft already
  if (c_.state == Task::Release && force.kind == ForceFinding::Kind::Up) return std::nullopt;
  const bool from_below = c_.state == Task::Lower && force.kind == ForceFinding::Kind::Up;
  if (!from_below) return TaskEvent{Event::Blocked, presumed_source(c_, force) + describe(force)};
  // where it was grasped, what pushes up is the ground, and so it is higher up under an object that slid in
  // the hand and is seen to stand: lowering judges that itself
  if (c_.arm.view().height_m < c_.config.task.carry.standing_tolerance_m || object_.seen_standing())
    return std::nullopt;
  return TaskEvent{Event::Obstructed, presumed_source(c_, force) + describe(force)};
}

bool TaskRunner::nobody_near_hand() const {
  return separation_.nobody_within(c_.config.task.empty_hand.touch_clear_m);
}

// what blocks an open hand right before or beside the object, with nobody near, is the object
TaskEvent TaskRunner::as_touch(TaskEvent event) const {
  const bool at_object =
      (c_.state == Task::Approach && approach_phase_.leg() == ApproachPhase::Leg::Straight) ||
      (c_.state == Task::Retreat && retreat_phase_.may_touch());
  if (event.event == Event::Blocked && at_object && c_.arm.touched() &&
      c_.config.task.empty_hand.max_touch_s > 0.0 && nobody_near_hand())
    event.event = Event::TouchedObject;
  return event;
}

bool TaskRunner::waits_for_arm() const {
  return arm_.interrupted() && c_.state != Task::Observe && c_.state != Task::AwaitPartner;
}

void TaskRunner::resume_after_restart() {
  c_.note_device("arm", "continues from the current position");
  // a hand at work continues by itself, and so does a lift whose arm was not commanded: from its height
  if (c_.state == Task::TestLift || c_.state == Task::Lift || c_.state == Task::Lower) c_.arm.resume_lift();
  if (c_.state == Task::Approach) approach_phase_.resume_after_restart();
  if (c_.state == Task::BackOff) back_off_phase_.resume_after_restart();
  if (c_.state == Task::Retreat) retreat_phase_.resume_after_restart();
}

std::optional<TaskEvent> TaskRunner::work() {
  switch (c_.state) {
    case Task::Observe:
      return scene_phase_.observe();
    case Task::AwaitPartner:
      return partner_phase_.await_partner();
    case Task::Decide:
      return plan_phase_.decide();
    case Task::Plan:
      return plan_phase_.plan();
    case Task::Approach:
      return approach_phase_.approach();
    case Task::Halt:
      return approach_phase_.halt();
    case Task::BackOff:
      return back_off_phase_.back_off();
    case Task::Contact:
      return contact_phase_.contact(nobody_near_hand());
    case Task::Close:
      return grip_phase_.close();
    case Task::Verify:
      return grip_phase_.verify();
    case Task::AwaitReady:
      return grip_phase_.await_ready();
    case Task::TestLift:
      return test_lift_phase_.test_lift();
    case Task::Lift:
      return lift_phase_.lift();
    case Task::Hold:
      return lift_phase_.hold();
    case Task::Lower:
      return lift_phase_.lower();
    case Task::Pause:
      return pause_phase_.pause();
    case Task::Yield:
      return yield_phase_.yield();
    case Task::Release:
      return retreat_phase_.release();
    case Task::Retreat:
      return retreat_phase_.retreat();
    case Task::Done:
    case Task::Refused:
    case Task::Aborted:
    case Task::Stopped:
      break;
  }
  return std::nullopt;
}

void TaskRunner::begin_state(Task from, Event event) {
  switch (c_.state) {
    case Task::AwaitPartner:
      return partner_phase_.begin(from);
    case Task::Decide:
      return plan_phase_.begin_decision();
    case Task::Approach:
      return approach_phase_.begin();
    case Task::Halt:
      return approach_phase_.begin_halt();
    case Task::BackOff:
      return back_off_phase_.begin(event, approach_phase_.abandon(), approach_phase_.set_out());
    case Task::Contact:
      return contact_phase_.begin(detail_);
    case Task::Close:
      return grip_phase_.begin_close();
    case Task::Verify:
      return grip_phase_.begin_verify();
    case Task::AwaitReady:
      return grip_phase_.begin_await_ready();
    case Task::TestLift:
      return test_lift_phase_.begin();
    case Task::Lift:
      return lift_phase_.begin_lift(from);
    case Task::Hold:
      return lift_phase_.begin_hold();
    case Task::Lower:
      if (event == Event::LowerConfirmed) pause_phase_.lowering_confirmed();
      return lift_phase_.begin_lower();
    case Task::Pause:
      return pause_phase_.begin(from, event, detail_);
    case Task::Yield:
      return yield_phase_.begin(from, detail_);
    case Task::Release:
      return retreat_phase_.begin_release();
    case Task::Retreat:
      return retreat_phase_.begin_retreat(from == Task::Contact);
    case Task::Stopped:
    case Task::Refused:
    case Task::Aborted:
    case Task::Done:
      return c_.arm.hold();
    case Task::Observe:
    case Task::Plan:
      break;
  }
}

void TaskRunner::apply(const TaskEvent& event, const JobHooks& hooks) {
  const auto rule = next(c_.state, event.event);
  if (!rule) return;
  const Task from = std::exchange(c_.state, rule->to);
  c_.since = c_.now;
  c_.waited_s = 0.0;
  c_.doing.clear();
  c_.done.reset();
  reason_ = rule->reason;
  if (!event.detail.empty()) reason_ += ": " + event.detail;
  detail_ = event.detail;
  c_.record.states.push_back({c_.now - c_.began, c_.state, reason_});
  if (is_failure(from, event.event, c_.state)) {
    c_.attempts.failed = true;
    c_.attempts.failure = reason_;
  }
  if (event.event == Event::ArmLost || event.event == Event::HandLost || event.event == Event::FingerLost)
    c_.record.device_failed = true;
  if (event.event == Event::FingerLost) hand_.continue_without_puck();
  if ((event.event == Event::GripBad || event.event == Event::HandEmpty) &&
      (from == Task::Close || from == Task::Verify))
    grasps_.refuse_grip("a grip here failed: " + event.detail);
  if (event.event == Event::TouchedObject && from == Task::Approach) {
    c_.attempts.touched = true;
    grasps_.refuse_approach("the hand met something on its way here: " + event.detail);
  }
  if (c_.state != Task::Yield && c_.state != Task::Stopped) c_.arm.expect(expected_load(c_.state));
  begin_state(from, event.event);
  if (event.event == Event::PartnerAsked) ask_partner(requests_.place(), hooks);
  if (const auto place = pause_phase_.asked_place(); c_.state == Task::Pause && place)
    ask_partner(*place, hooks);
  if (hooks.changed) hooks.changed(from, c_.state);
  report(hooks);
}

void TaskRunner::ask_partner(const hal::Vec3& place, const JobHooks& hooks) {
  c_.request(
      fmt::format("please grasp the object at ({:.2f}, {:.2f}, {:.2f}) m", place.x(), place.y(), place.z()));
  if (hooks.asked) hooks.asked({place, std::nullopt});
}

void TaskRunner::report(const JobHooks& hooks) {
  reported_at_ = c_.now;
  if (!hooks.status) return;
  JobStatus s;
  s.now = c_.now - c_.began;
  s.state = c_.state;
  s.since = c_.since - c_.began;
  s.reason = reason_;
  s.doing = c_.doing;
  s.done = c_.done;
  separation_.report(s.separation);
  if (s.separation.waits)
    s.doing = (s.separation.may_confirm ? "waits for confirmation: " : "waits: ") + s.separation.reason;
  if (const auto grasp = c_.session.tracker().grasp()) s.partner_W = grasp->position;
  s.partner_note = c_.partner_note;
  s.load_n = c_.arm.view().load_n;
  report_force(s.force);
  if (is_loaded(c_.state) && !c_.record.curve.empty()) {
    s.height_m = c_.record.curve.back().palm_height_m;
    if (!std::isnan(object_.tilt_rad())) s.tilt_rad = object_.tilt_rad(), s.slip_m = object_.slip_m();
  }
  s.share_robot = lift_phase_.share_robot();
  s.record = &c_.record;
  if (c_.record.analysis && c_.record.analysis->scene.target) s.map = &c_.session.map();
  s.map_version = c_.map_version;
  hooks.status(s);
}

void TaskRunner::report_force(ForceStatus& out) const {
  const ForceMonitorConfig& config = c_.config.monitor.force;
  const ArmView& arm = c_.arm.view();
  out.on = config.on;
  out.felt_W = arm.felt_W.force;
  out.exceeded = static_cast<bool>(arm.force);
  if (const ForceLimits* limits = force_limits(config, expected_load(c_.state))) out.limits = *limits;
}

RunRecord TaskRunner::finish() {
  RunRecord& record = c_.record;
  record.hand_keeps_grip = c_.readings.hand.held && !yield_phase_.lost();
  // at rest before it is left alone, whatever it was doing
  c_.arm.finish();
  c_.robot.hand->stop();
  c_.robot.camera->deactivate();
  for (const auto& camera : c_.robot.more_cameras) camera->deactivate();
  using Result = RunRecord::Result;
  switch (c_.state) {
    case Task::Done:
      record.outcome = Result::Lifted;
      record.reason = fmt::format("held {:.1f} cm for {:g} s, lowered, released",
                                  1e2 * (record.lift ? record.lift->height_m : 0.0),
                                  std::round(10.0 * held_s(record.states)) / 10.0);
      break;
    case Task::Refused:
      record.outcome = c_.attempts.approaches > 0 ? Result::Aborted : Result::Refused;
      record.reason = reason_;
      break;
    default:
      record.outcome = Result::Aborted;
      record.reason =
          c_.state == Task::Aborted && !c_.attempts.failure.empty() ? c_.attempts.failure : reason_;
  }
  record.timing.sim_s = hal::seconds(c_.robot.clock->now() - c_.began);
  record.timing.wall_s = hal::seconds(c_.stopwatch.now() - wall_start_);
  return std::move(record);
}

hal::Result<RunRecord> run_job(hal::Robot& robot, const RigView& rig, const Config& config,
                               const JobOptions& options, const JobHooks& hooks,
                               const hal::Clock& stopwatch) {
  return TaskRunner(robot, rig, config, options, stopwatch).run(hooks);
}

}  // namespace colift::control
