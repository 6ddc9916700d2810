#include "control/task/job.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace colift::control {
namespace {

using namespace std::chrono_literals;

constexpr hal::Duration kTellEvery = 33ms;
constexpr double kCarefully_m_s = 0.005;

planner::ArmGeometry geometry_of(const hal::RobotModel& model) {
  // every model that load_robot() lets pass has this arm
  return planner::arm_geometry(model).value();
}

SetpointLimits cycle_limits(const Config& config) {
  SetpointLimits limits;
  limits.velocity_rad_s = 0.9 * config.guard_arm.max_velocity_rad_s;
  return limits;
}

}  // namespace

Job::Job(hal::Robot& robot, const RigView& rig, const Config& config, const JobOptions& options,
         const hal::Clock& stopwatch)
    : robot_(robot),
      rig_(rig),
      config_(config),
      options_(options),
      stopwatch_(stopwatch),
      geometry_(geometry_of(rig.model)),
      watch_(options.method, config_, rig, stopwatch),
      planner_(std::make_unique<planner::MotionPlanner>(rig.model, rig.hand, config.motion, options.seed)),
      loop_(*robot.arm, rig.model, geometry_, config.task, config.load, options.drive, cycle_limits(config)),
      tests_(config.test_lift) {
  if (options.recorded_views) loop_.play(options.recorded_views);
}

std::optional<Happening> Job::work() {
  switch (state_) {
    case Task::Observe:
      return observe();
    case Task::AwaitPartner:
      return await_partner();
    case Task::Decide:
      return decide();
    case Task::Plan:
      return plan();
    case Task::Approach:
      return approach();
    case Task::Halt:
      return halt();
    case Task::BackOff:
      return back_off();
    case Task::Close:
      return close();
    case Task::Verify:
      return verify();
    case Task::AwaitReady:
      return await_ready();
    case Task::TestLift:
      return test_lift();
    case Task::Lift:
      return lift();
    case Task::Hold:
      return hold();
    case Task::Lower:
      return lower();
    case Task::Release:
      return release();
    case Task::Retreat:
      return retreat();
    case Task::Done:
    case Task::Refused:
    case Task::Aborted:
    case Task::Stopped:
      break;
  }
  return std::nullopt;
}

bool Job::cycle(const JobHooks& hooks) {
  read_devices();
  // trouble first; where it means nothing, the work goes on
  const auto trouble = emergency(hooks);
  if (trouble && next(state_, trouble->event)) {
    apply(*trouble, hooks);
  } else if (waits_for_arm()) {
    doing_ = "the arm stands until its controller takes commands again";
  } else {
    if (cut_off_) take_up();
    if (const auto happening = work()) apply(*happening, hooks);
  }
  loop_.end_cycle();
  if (loop_.view().refused_commands > 0 && !refusal_told_ && !is_end(state_)) {
    refusal_told_ = true;
    lose("arm", loop_.view().refusal.str());
  }
  if (now_ - told_ >= kTellEvery) tell(hooks);
  if (hooks.cycle) hooks.cycle(loop_.view());
  return !is_end(state_);
}

void Job::apply(const Happening& happening, const JobHooks& hooks) {
  const auto rule = next(state_, happening.event);
  if (!rule) return;
  const Task from = state_;
  state_ = rule->to;
  since_ = now_;
  doing_.clear();
  done_.reset();
  std::string because(rule->because);
  if (!happening.detail.empty()) because += ": " + happening.detail;
  record_.states.push_back({now_ - began_, state_, because});
  last_because_ = because;
  if (happening.event == Event::LimitReached || happening.event == Event::HangsAskew ||
      (from == Task::TestLift && state_ == Task::Lower) ||
      (state_ == Task::Release && happening.event != Event::OnGround) || state_ == Task::BackOff) {
    failed_ = true;
    failed_because_ = because;
  }
  if (happening.event == Event::ArmLost || happening.event == Event::HandLost ||
      happening.event == Event::FingerLost)
    record_.device_failed = true;
  if (happening.event == Event::FingerLost) {
    without_puck_ = puck_alone_;
    hand_silent_ = false;  // the others are to answer from now on
  }
  off_because_ = happening.event;
  if (happening.event == Event::GripBad || happening.event == Event::HandEmpty)
    if (from == Task::Close || from == Task::Verify) refuse_grip("a grip here failed: " + happening.detail);
  enter(from);
  if (happening.event == Event::PartnerAsked && hooks.asked) hooks.asked(asked_->to);
  if (hooks.changed) hooks.changed(from, state_);
  tell(hooks);
}

void Job::enter(Task from) {
  switch (state_) {
    case Task::AwaitPartner:
      waits_since_ = now_;
      failed_ = regrasp_ = false;
      if (from != Task::Observe) watch_.forget_partner();
      break;
    case Task::Decide:
      if (judged_.empty()) judged_ = watch_.look().candidates;
      watch_.look().candidates = judged_;
      refused_.clear();
      break;
    case Task::Approach:
      moved_ = true;
      ++approaches_;
      loop_.start_tare();
      if (const auto opened = robot_.hand->preshape(0.0); !opened) lose("hand", opened.error().text());
      leg_ = follow(record_.plan->transit) ? 0 : -1;
      break;
    case Task::Halt:
      loop_.hold();
      break;
    case Task::BackOff:
      loop_.hold();
      was_near_ = leg_ == 1;
      leg_ = 2;
      break;
    case Task::Close:
      X_WH_closed_ = palm();
      if (const auto closing = robot_.hand->close(config_.task.close_torque_nm); !closing)
        lose("hand", closing.error().text());
      break;
    case Task::AwaitReady:
      X_WH_closed_ = palm();
      partner_top_m_ = 0.0;
      break;
    case Task::TestLift:
      begin_test_lift();
      break;
    case Task::Lift:
      lifted_ = true;
      settled_at_ = now_;
      if (from == Task::TestLift) {
        // what hung still when it was raised slowly is raised slowly
        const double left_m = config_.task.lift_height_m - loop_.view().height_m;
        lift_s_ = std::max(config_.task.lift_s, left_m / kCarefully_m_s);
        loop_.raise_on(role_, config_.task.lift_height_m, lift_s_);
      } else {
        lift_s_ = config_.task.lift_s;
        loop_.start_lift(role_, config_.task.lift_height_m, lift_s_);
      }
      break;
    case Task::Hold:
      hold_load_n_ = NAN;
      record_.frame_lifted.reset();
      break;
    case Task::Lower:
      summarise_hold();
      settled_at_ = unloaded_since_ = now_;
      loop_.lower();
      break;
    case Task::Release:
      loop_.hold();
      loop_.unload();
      if (const auto opening = robot_.hand->release(); !opening) lose("hand", opening.error().text());
      break;
    case Task::Retreat:
      leg_ = 0;
      back_to_pre_grasp();
      break;
    case Task::Stopped:
    case Task::Refused:
    case Task::Aborted:
    case Task::Done:
      loop_.hold();
      break;
    default:
      break;
  }
}

void Job::tell(const JobHooks& hooks) {
  told_ = now_;
  if (!hooks.status) return;
  JobStatus s;
  s.now = now_ - began_;
  s.state = state_;
  s.since = since_ - began_;
  s.because = last_because_;
  s.doing = doing_;
  s.done = done_;
  if (const auto grasp = watch_.tracker().grasp()) s.partner_W = grasp->position;
  s.partner_note = partner_note_;
  s.load_n = loop_.view().load_n;
  if (is_loaded(state_) && !record_.curve.empty()) {
    const LiftSample& last = record_.curve.back();
    s.height_m = last.palm_height_m;
    if (!std::isnan(tilt_rad_)) s.tilt_rad = tilt_rad_, s.slip_m = slip_m_;
  }
  s.record = &record_;
  if (record_.look && record_.look->scene.target) s.map = &watch_.map();
  hooks.status(s);
}

RunRecord Job::finish() {
  // at rest before it is left alone, whatever it was doing
  loop_.finish();
  record_.hand_keeps_grip = hand_.held;
  robot_.hand->stop();
  robot_.camera->deactivate();
  using Result = RunRecord::Result;
  switch (state_) {
    case Task::Done:
      record_.outcome = Result::Lifted;
      record_.because = fmt::format("held {:.1f} cm for {:.0f} s, lowered, released",
                                    1e2 * (record_.lift ? record_.lift->height_m : 0.0), config_.task.hold_s);
      break;
    case Task::Refused:
      record_.outcome = moved_ ? Result::Aborted : Result::Refused;
      record_.because = last_because_;
      break;
    default:
      record_.outcome = Result::Aborted;
      record_.because = state_ == Task::Aborted && !failed_because_.empty() ? failed_because_ : last_because_;
  }
  record_.timing.sim_s = hal::seconds(robot_.clock->now() - began_);
  record_.timing.wall_s = hal::seconds(stopwatch_.now() - wall_start_);
  return std::move(record_);
}

}  // namespace colift::control
