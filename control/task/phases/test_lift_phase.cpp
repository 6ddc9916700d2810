#include "control/task/phases/test_lift_phase.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <string>

namespace colift::control {
double TestLiftPhase::height_m() const {
  return std::min(c_.config.test_lift.height_m, c_.config.task.lift_height_m);
}

void TestLiftPhase::begin() {
  leg_ = Leg::Raising;
  c_.test_lifts.begin(carried_object(*c_.session.analysis().scene.target),
                      c_.record.decision->partner->position, planner::load_point(c_.chosen()),
                      c_.record.decision->decision.share);
  const double fraction = height_m() / c_.config.test_lift.height_m;
  // with a stiff palm: one that gave way would turn with the object, whose turns are what is to be seen
  c_.arm.start_lift(LiftController::Role::Lead, height_m(), fraction * c_.config.test_lift.raise_s);
}

std::optional<TaskEvent> TestLiftPhase::test_lift() {
  object_.update();
  partner_.update();
  if (auto gone = partner_.let_go()) return gone;
  if (auto end = object_.end_of_reach()) return end;
  if (auto limit = object_.beyond_limits()) return limit;
  const double now_m = c_.arm.view().height_m;
  if (object_.partner_lifts_first()) {
    c_.role = LiftController::Role::Follow;
    return TaskEvent{Event::PartnerReady, fmt::format("his end is {:.0f} mm up: the robot follows",
                                                      1e3 * object_.partner_rise_m())};
  }
  const TaskConfig& task = c_.config.task;
  if (c_.in_state_s() > c_.config.test_lift.raise_s / task.slow_fraction + task.partner_timeout_s)
    return TaskEvent{Event::TimeOut, fmt::format("{:.0f} mm after {:.0f} s", 1e3 * now_m, c_.in_state_s())};
  if (leg_ == Leg::Measuring) return measure();
  raise();
  return std::nullopt;
}

void TestLiftPhase::raise() {
  const double now_m = c_.arm.view().height_m;
  c_.doing = fmt::format("raises slowly to learn where it is heavy: {:.0f} mm", 1e3 * now_m);
  c_.done = now_m / height_m();
  const bool enough =
      c_.readings.frame && object_.motion() && c_.test_lifts.rising(*object_.motion()) == Raise::Enough;
  if (enough) c_.arm.stay();
  if (enough || c_.arm.lift_at_rest()) {
    leg_ = Leg::Measuring;
    at_top_since_ = c_.now;
  }
}

std::optional<TaskEvent> TestLiftPhase::measure() {
  const double rested_s = hal::seconds(c_.now - at_top_since_);
  const double settle_s = c_.config.task.carry.settle_s;
  if (rested_s < settle_s) return std::nullopt;
  const double hold_s = c_.config.test_lift.hold_s;
  c_.doing = fmt::format("measures mass and centre of gravity at {:.0f} mm", 1e3 * c_.arm.view().height_m);
  c_.done = (rested_s - settle_s) / hold_s;
  if (c_.readings.frame && object_.motion()) c_.test_lifts.at_top(c_.readings.frame_at, *object_.motion());
  if (const auto& wrench_W = c_.arm.view().wrench_W) c_.test_lifts.feel(*wrench_W, c_.palm().translation());
  if (rested_s < settle_s + hold_s) return std::nullopt;
  return judge();
}

TaskEvent TestLiftPhase::judge() {
  auto known = c_.test_lifts.end();
  TestLiftRecord& entry = c_.record.test_lifts.emplace_back();
  entry.at = c_.now - c_.began;
  entry.candidate = c_.chosen().id;
  entry.height_m = c_.arm.view().height_m;
  if (!known) {
    entry.reason = known.error().detail;
    const std::string why = "the centre of gravity cannot be determined: " + entry.reason;
    grasps_.refuse_grip(why);
    c_.attempts.regrasp = static_cast<int>(c_.record.test_lifts.size()) < c_.config.test_lift.grips;
    return {Event::HangsAskew, why};
  }
  entry.known = *known;
  entry.reason = known->reason;
  const bool last_chance = grasps_.accepts_bearable() && known->bearable;
  if (known->next != TestLift::Next::Regrasp || last_chance) return {Event::HangsLevel, known->reason};
  if (known->bearable) grasps_.keep_bearable(known->share, known->seen.tilt_rad);
  c_.attempts.regrasp = true;
  return {Event::HangsAskew, known->reason};
}

}  // namespace colift::control
