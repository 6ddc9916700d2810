#include "control/recovery/recovery.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace colift::control {
namespace {

using namespace std::chrono_literals;

constexpr hal::Duration kBrakes = 3s, kShows = 100ms;  // until a request shows in the view

}  // namespace

Recovery::Recovery(hal::Robot& robot, const RigView& rig, const Config& config,
                   const RecoveryOptions& options, const hal::Clock& stopwatch)
    : robot_(robot),
      rig_(rig),
      config_(config),
      options_(options),
      stopwatch_(stopwatch),
      geometry_(planner::arm_geometry(rig.model).value()),
      arm_(*robot.arm, rig.model, geometry_, config.task, config.load, options.drive,
           config.setpoints.below(config.guard_arm)) {}

RecoveryRecord Recovery::run(const RecoveryHooks& hooks) {
  hooks_ = &hooks;
  began_ = now_ = since_ = robot_.clock->now();
  apply(assess_now());
  while (!ended()) {
    auto finding = begin();
    while (!finding) finding = cycle();
    apply(*finding);
  }
  if (arm_started_) arm_.finish();
  record_.recovered = step_ == RecoveryStep::Done;
  record_.arm_at_rest = arm_started_ ? arm_.view().at_rest
                                     : record_.before.arm == Assessment::Arm::AtHome ||
                                           record_.before.arm == Assessment::Arm::Away;
  robot_.hand->stop();
  robot_.camera->deactivate();
  return std::move(record_);
}

Recovery::Finding Recovery::assess_now() {
  std::vector<hal::ArmState> states;
  if (auto open = robot_.arm->configure(); !open) {
    record_.before.arm_words = "unknown: " + open.error().text();
  } else {
    const hal::Timestamp start = robot_.clock->now();
    while (hal::seconds(robot_.clock->now() - start) < config_.recovery.assess_timeout_s) {
      if (hooks_->interrupted()) return {Event::Interrupted, ""};
      const auto state = robot_.arm->wait_cycle();
      if (!state && state.error().code != hal::ErrorCode::Timeout) break;
      if (!state) continue;
      states.push_back(*state);
      const auto seen = states.back().measured_at - states.front().measured_at;
      if (hal::seconds(seen) >= config_.recovery.assess_s) break;
    }
  }
  std::string hand_fault;
  if (auto open = robot_.hand->configure(); !open)
    hand_fault = open.error().text();
  else if (auto active = robot_.hand->activate(); !active)
    hand_fault = active.error().text();
  else if (auto state = robot_.hand->state(); !state)
    hand_fault = state.error().text();
  else
    hand_ = *state;
  record_.before = assess(states, hand_, options_.home_rad, rig_.model, rig_.hand, config_.recovery);
  const Assessment& a = record_.before;
  if (!hand_fault.empty()) record_.before.hand_words = "unknown: " + hand_fault;
  now_ = hand_at_ = robot_.clock->now();
  hooks_->say("arm:  " + a.arm_words);
  hooks_->say("hand: " + a.hand_words);
  hooks_->say("load: " + a.load_words);
  if (a.arm == Assessment::Arm::Unknown) return {Event::DeviceLost, a.arm_words};
  if (a.hand == Assessment::Hand::Unknown) return {Event::HandUnknown, hand_fault};
  if (a.arm == Assessment::Arm::Moving) return {Event::TimeOut, "the arm " + a.arm_words};
  if (a.may_hold()) return {Event::HandHolds, a.hand_words};
  return {a.arm == Assessment::Arm::AtHome ? Event::AtHome : Event::HandOpen, ""};
}

void Recovery::apply(const Finding& finding) {
  const auto rule = next(step_, finding.event);
  if (!rule) return;
  attempt_ = rule->to == step_ ? attempt_ + 1 : 1;
  if (attempt_ > 1) arm_.hold();
  step_ = rule->to;
  since_ = now_;
  record_.reason = std::string(rule->reason);
  if (!finding.detail.empty()) record_.reason += ": " + finding.detail;
  record_.steps.push_back({now_ - began_, step_, record_.reason});
  hooks_->say(fmt::format("{}: {}", word(step_), record_.reason));
  record_.device_failed = finding.event == Event::DeviceLost || finding.event == Event::HandUnknown;
  record_.interrupted = finding.event == Event::Interrupted;
  if (ended() && arm_started_) arm_.hold();
}

std::string Recovery::announcement() const {
  const RecoveryConfig& c = config_.recovery;
  switch (step_) {
    case RecoveryStep::Lower:
      return fmt::format(
          "lowers the hand straight down, with {:.0f} mm/s, until the load is borne, at most {:.0f} cm",
          1e3 * c.lower_speed_m_s, 1e2 * c.max_lower_m);
    case RecoveryStep::TakeOver:
      return fmt::format("holds still until a person bears the object, of which the hand bears {:.0f} N",
                         arm_.view().load_n);
    case RecoveryStep::Release:
      if (arm_.view().load_n < c.supported_n) return "opens the hand";
      return fmt::format(
          "opens the hand, which bears {:.0f} N: whoever holds the object has to bear them then",
          arm_.view().load_n);
    case RecoveryStep::DrawBack:
      return fmt::format("draws the open hand straight back by {:.0f} cm", 1e2 * c.clear_m);
    case RecoveryStep::Home:
      return planned_ ? "moves home, around what the camera observes"
                      : "moves home in a straight line of the joints: NOT checked for collisions";
    default:
      return "";
  }
}

// what met something comes to rest, and no longer wants to be where it did not come to
std::optional<Recovery::Finding> Recovery::stop_pressing() {
  const auto rest = [&]() -> std::optional<Finding> {
    const hal::Timestamp begun = now_;
    while (now_ - begun < kBrakes && (now_ - begun < kShows || !arm_.view().at_rest)) {
      auto lost = read_devices();
      arm_.end_cycle();
      if (lost) return lost;
    }
    return std::nullopt;
  };
  if (auto lost = rest()) return lost;
  arm_.ease();
  return rest();
}

std::optional<Recovery::Finding> Recovery::begin() {
  if (attempt_ > 1)
    if (auto lost = stop_pressing()) return lost;
  if (step_ == RecoveryStep::Home)
    if (auto failed = prepare_home()) return failed;
  const bool told = step_ == RecoveryStep::TakeOver && person_holds_;
  const Confirmation answer = told ? Confirmation::PersonHolds : hooks_->confirm(step_, announcement());
  if (step_ == RecoveryStep::TakeOver && answer != Confirmation::PersonHolds)
    return Finding{Event::Declined, record_.reason};
  if (answer == Confirmation::No) return Finding{Event::Declined, ""};
  if (!arm_started_) {
    if (auto started = arm_.start(); !started) return Finding{Event::DeviceLost, started.error().text()};
    arm_started_ = true;
  }
  person_holds_ = answer == Confirmation::PersonHolds;
  if (person_holds_ && step_ == RecoveryStep::Lower) return Finding{Event::PersonHolds, ""};
  auto finding = read_devices();  // a confirmation takes its time
  since_ = unsupported_at_ = now_;
  paused_ = presses_ = false;
  if (!finding) finding = begin_step();
  arm_.end_cycle();
  return finding;
}

std::optional<Recovery::Finding> Recovery::begin_step() {
  const RecoveryConfig& c = config_.recovery;
  const auto follow = [&](const planner::Trajectory& path) -> std::optional<Finding> {
    if (auto started = arm_.follow(path); !started) return Finding{Event::Blocked, started.error().text()};
    return std::nullopt;
  };
  switch (step_) {
    case RecoveryStep::Lower:
      load_before_n_ = arm_.view().load_n;
      arm_.start_lift(LiftController::Role::Lead, -c.max_lower_m, c.max_lower_m / c.lower_speed_m_s);
      return std::nullopt;
    case RecoveryStep::TakeOver:
      arm_.hold();
      return std::nullopt;
    case RecoveryStep::Release:
      arm_.hold();
      arm_.unload();
      if (auto opening = robot_.hand->release(); !opening)
        return Finding{Event::DeviceLost, opening.error().text()};
      return std::nullopt;
    case RecoveryStep::DrawBack: {
      const auto back = draw_back_path();
      if (!back) return Finding{Event::Clear, "there is no room to draw it back"};
      return follow(*back);
    }
    case RecoveryStep::Home:
      return follow(home_);
    default:
      return std::nullopt;
  }
}

std::optional<Recovery::Finding> Recovery::cycle() {
  auto finding = read_devices();
  if (!finding) finding = work();
  arm_.end_cycle();
  return finding;
}

std::optional<Recovery::Finding> Recovery::read_devices() {
  const SupervisionConfig& limits = config_.task.supervision;
  arm_.begin_cycle();
  read_at_ = std::exchange(now_, robot_.clock->now());
  if (hooks_->interrupted()) return Finding{Event::Interrupted, ""};
  const ArmView& view = arm_.view();
  if (view.link_lost || view.misses > limits.arm_max_misses)
    return Finding{Event::DeviceLost, view.fault.str()};
  if (std::exchange(refused_commands_, view.refused_commands) == view.refused_commands)
    refused_since_.reset();
  else if (!refused_since_)
    refused_since_ = now_;
  else if (hal::seconds(now_ - *refused_since_) > config_.task.arm_timeout_s)
    return Finding{Event::DeviceLost, "it refuses commands: " + view.refusal.str()};
  if (view.misses == 0 && (!view.state.may_command || !view.running)) {
    if (!not_commanded_since_) not_commanded_since_ = now_;
    if (hal::seconds(now_ - *not_commanded_since_) > config_.task.arm_timeout_s)
      return Finding{Event::DeviceLost, "the arm's controller takes no commands"};
  } else {
    not_commanded_since_.reset();
  }
  if (options_.drive == Drive::Thread &&
      arm_thread_.update(view.cycles + view.missed, now_) > limits.beat_timeout_s)
    return Finding{Event::DeviceLost, "the arm's thread does not run"};
  if (auto state = robot_.hand->state()) {
    hand_ = *state;
    hand_at_ = now_;
  } else if (hal::seconds(now_ - hand_at_) > limits.hand_timeout_s && now_ - read_at_ < 100ms) {
    return Finding{Event::DeviceLost, state.error().text()};
  }
  return std::nullopt;
}

std::optional<Recovery::Finding> Recovery::work() {
  if (in_step_s() > config_.recovery.step_timeout_s) return Finding{Event::TimeOut, ""};
  switch (step_) {
    case RecoveryStep::Lower:
      return lower();
    case RecoveryStep::TakeOver:
      return take_over();
    case RecoveryStep::Release:
      return release();
    case RecoveryStep::DrawBack:
      return move(Event::Clear);
    case RecoveryStep::Home:
      return move(Event::AtHome);
    default:
      return std::nullopt;
  }
}

void Recovery::lower_on() {
  const RecoveryConfig& c = config_.recovery;
  arm_.raise_on(LiftController::Role::Lead, -c.max_lower_m,
                (c.max_lower_m + arm_.view().height_m) / c.lower_speed_m_s);
}

bool Recovery::pausing() {
  const bool lowers = step_ == RecoveryStep::Lower;
  const bool stalled = arm_.stalled();
  if (!hooks_->may_move()) {
    if (!std::exchange(paused_, true)) {
      if (lowers)
        arm_.stay();
      else
        arm_.hold();
    }
  } else if (stalled || paused_) {
    paused_ = true;
    if (!arm_.view().at_rest) return true;
    paused_ = false;
    if (!lowers) {
      arm_.resume();
    } else {
      if (stalled) arm_.resume_lift();
      if (!presses_) lower_on();
    }
  }
  if (paused_) since_ += now_ - read_at_;
  return paused_;
}

std::optional<Recovery::Finding> Recovery::lower() {
  const RecoveryConfig& c = config_.recovery;
  if (arm_.end_of_reach()) return Finding{Event::EndOfReach, ""};
  if (pausing()) {
    unsupported_at_ = now_;
    return std::nullopt;
  }
  const ArmView& view = arm_.view();
  // a small load may be the error of what is measured: then only the ground that pushes up is evidence
  const double limit_n = load_before_n_ < 2.0 * c.supported_n
                             ? -c.supported_n
                             : std::max(c.supported_n, c.supported_fraction * load_before_n_);
  // an object that stands on some of its feet only may lean on the hand sideways, and weigh nothing there
  const double sideways_n = view.wrench_W ? view.wrench_W->force.head<2>().norm() : 0.0;
  const bool borne = view.load_n <= limit_n && sideways_n <= c.supported_sideways_n;
  // pressed on the ground it goes no further; what yields is not the ground
  if (!presses_ && view.load_n <= -c.press_n) {
    presses_ = true;
    arm_.stay();
  } else if (presses_ && view.load_n > -0.5 * c.press_n) {
    presses_ = false;
    lower_on();
  }
  if (!borne && !presses_) unsupported_at_ = now_;
  if (hal::seconds(now_ - unsupported_at_) > c.settle_s) {
    arm_.stay();
    return Finding{Event::Supported,
                   fmt::format("lowered by {:.0f} mm, load from {:.0f} to {:.0f} N, {:.0f} N sideways",
                               -1e3 * view.height_m, load_before_n_, view.load_n, sideways_n)};
  }
  if (presses_ || !arm_.lift_at_rest()) return std::nullopt;
  return Finding{Event::NoGround, fmt::format("lowered by {:.0f} mm, the load is {:.0f} N",
                                              -1e3 * view.height_m, view.load_n)};
}

// a person's word is believed, but the hand waits until he bears what it bore, and else says how much it
// still does
std::optional<Recovery::Finding> Recovery::take_over() {
  const RecoveryConfig& c = config_.recovery;
  const double load_n = arm_.view().load_n;
  if (std::abs(load_n) > c.supported_n) unsupported_at_ = now_;
  const bool borne = hal::seconds(now_ - unsupported_at_) > c.settle_s;
  if (!borne && in_step_s() <= c.take_over_s) return std::nullopt;
  return Finding{borne ? Event::Supported : Event::PersonHolds,
                 fmt::format("{:.0f} N are left on the hand", load_n)};
}

std::optional<Recovery::Finding> Recovery::release() {
  if (in_step_s() > config_.task.grip.hand_timeout_s)
    return Finding{last_attempt() ? Event::TimeOut : Event::Obstructed, ""};
  if (in_step_s() < config_.task.grip.command_shows_s || hand_->moving || hand_->held) return std::nullopt;
  const auto& q = hand_->finger_rad;
  if (*std::max_element(q.begin(), q.end()) > config_.recovery.open_tolerance_rad) return std::nullopt;
  return Finding{Event::HandOpened, ""};
}

std::optional<Recovery::Finding> Recovery::move(Event arrived) {
  if (pausing()) return std::nullopt;
  if (arm_.blocked()) return Finding{last_attempt() ? Event::Blocked : Event::Obstructed, arm_.why_blocked()};
  if (!arm_.done() || !arm_.at_rest()) return std::nullopt;
  return Finding{arrived, ""};
}

}  // namespace colift::control
