#include "control/task/phases/grip_phase.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "hal/types/units.hpp"

namespace colift::control {
namespace {

constexpr double kMaxEase_m = 0.03;  // closing fingers move the palm by millimetres

/// Width between the third finger and the one of the others that is farther from it (m).
double felt_width(const planner::HandModel& hand, const hal::HandState& state) {
  const auto& q = state.finger_rad;
  return planner::half_gap_at(hand, std::min(q[0], q[1])) + planner::half_gap_at(hand, q[2]);
}

}  // namespace

void GripPhase::begin_close() {
  object_.set_grip();
  let_go_.start();
  doubt_.reset();
  if (const auto closing = c_.robot.hand->close(c_.config.task.close_torque_nm); !closing)
    c_.note_device("hand", closing.error().text());
}

std::optional<TaskEvent> GripPhase::let_go() {
  let_go_.update();
  if (auto seen = let_go_.let_go()) return seen;
  if (auto gone = partner_.let_go()) doubt_ = std::move(gone);
  // fingers that shift the object change its whole picture, but not that his hand is seen at his contact
  if (!doubt_ || let_go_.hand_seen().value_or(false)) return std::nullopt;
  return std::exchange(doubt_, std::nullopt);
}

bool GripPhase::partner_holds() const {
  return c_.session.tracker().state() == perception::PartnerTracker::State::Holding ||
         let_go_.hand_seen().value_or(false);
}

std::optional<TaskEvent> GripPhase::close() {
  const hal::HandState& hand = c_.readings.hand;
  c_.doing = "the fingers close";
  if (auto gone = let_go()) return gone;
  if (c_.in_state_s() > c_.config.task.grip.hand_timeout_s)
    return TaskEvent{Event::HandEmpty, "the hand does not come to rest"};
  if (hand.moving || c_.in_state_s() < c_.config.task.grip.command_shows_s) return std::nullopt;
  if (!hand.held)
    return TaskEvent{Event::HandEmpty, hand.warning.empty() ? "the fingers met nothing" : hand.warning.str()};
  return TaskEvent{Event::HandHeld, "every finger is stopped by the object"};
}

void GripPhase::begin_verify() {
  eased_at_ = c_.now;
  closed_W_ = c_.palm().translation();
}

// Fingers that meet the object one after the other shift it against the arm's springs and the partner. What
// takes the palm farther than that is somebody who pushes: he is not followed.
void GripPhase::ease() {
  const double ease_s = c_.config.task.grip.ease_s;
  if (ease_s == 0.0 || hal::seconds(c_.now - eased_at_) < ease_s) return;
  eased_at_ = c_.now;
  if ((c_.palm().translation() - closed_W_).norm() < kMaxEase_m) c_.arm.ease();
}

std::optional<std::string> GripPhase::too_weak(const GripQuality& quality) const {
  const GripConfig& grip = c_.config.task.grip;
  const auto mass_kg = c_.mass_kg();
  const double limit = mass_kg ? grip.min_friction_margin : grip.min_usual_margin;
  const double weight_n = hal::kGravity_m_s2 * mass_kg.value_or(c_.config.decision.usual_mass_kg);
  const double load_n = std::clamp(c_.record.decision->decision.share, 0.0, 1.0) * weight_n;
  const hal::Wrench load{-load_n * hal::Vec3::UnitZ(), hal::Vec3::Zero()};
  const double margin = slip_margin(quality, c_.chosen(), c_.rig.hand, load);
  if (!(margin < limit)) return std::nullopt;  // nor where it is not known
  return fmt::format(
      "by the force at its fingers the grip carries {:.0f} N of the {:.0f} N expected ({}; margin {:.2f}, "
      "limit {:.2f}): not lifted; it needs a larger task.close_torque_nm, or a cooler hand",
      margin * load_n, load_n,
      mass_kg ? fmt::format("{:.1f} kg", *mass_kg)
              : fmt::format("decision.usual_mass_kg, {:.1f} kg", c_.config.decision.usual_mass_kg),
      margin, limit);
}

// A finger of somebody, a cable: thicker than what was seen. Between pads the width tells, wherever in it the
// object lies; of fingers that wrap a bar each tells by itself how far it is from its middle.
std::optional<std::string> GripPhase::something_between(const hal::HandState& hand) const {
  const double limit_m = c_.config.task.grip.max_excess_width_m;
  const planner::GraspCandidate& grasp = c_.chosen();
  if (grasp.kind == planner::GraspKind::Wrap) {
    const double limit_rad = planner::stopped_angle(c_.rig.hand, grasp, limit_m);
    for (std::size_t f = 0; f < hand.finger_rad.size(); ++f)
      if (hand.finger_rad[f] < limit_rad)
        return fmt::format(
            "something is between F{} and the object: it stops at {:.0f} deg (by what was seen at {:.0f}; "
            "{:.0f} with {:.0f} mm between)",
            f + 1, hal::rad_to_deg(hand.finger_rad[f]),
            hal::rad_to_deg(planner::stopped_angle(c_.rig.hand, grasp)), hal::rad_to_deg(limit_rad),
            1e3 * limit_m);
    return std::nullopt;
  }
  const double excess_m = felt_width(c_.rig.hand, hand) - grasp.width;
  if (excess_m <= limit_m) return std::nullopt;
  return fmt::format(
      "something is between the fingers and the object: {:.0f} mm wider than it was seen (limit {:.0f} mm)",
      1e3 * excess_m, 1e3 * limit_m);
}

std::optional<TaskEvent> GripPhase::verify() {
  const hal::HandState& hand = c_.readings.hand;
  if (auto gone = let_go()) return gone;
  ease();
  // still for a moment, and as wide as the object was seen to be
  if (c_.in_state_s() < c_.config.task.carry.settle_s) return std::nullopt;
  const double expected = planner::stopped_angle(c_.rig.hand, c_.chosen());
  double widest = 0.0;
  for (const double q : hand.finger_rad) widest = std::max(widest, std::abs(q - expected));
  const GripQuality quality = grip_quality(hand, c_.config.task.close_torque_nm, c_.config.task.grip);
  c_.record.grip = quality;
  const std::string facts = fmt::format("fingers within {:.0f} deg of the observed width; {}",
                                        hal::rad_to_deg(widest), describe(quality));
  if (!hand.held) return TaskEvent{Event::GripBad, "the grip was lost: " + facts};
  const GripConfig& grip = c_.config.task.grip;
  const bool wraps = c_.chosen().kind == planner::GraspKind::Wrap;
  if (auto between = something_between(hand)) return TaskEvent{Event::GripBad, *between + "; " + facts};
  if (widest > grip.finger_tolerance_rad)
    return TaskEvent{Event::GripBad, "that does not match the observed object: " + facts};
  // fingers that wrap a bar press with their inner links, which have no gauge
  if (wraps) return TaskEvent{Event::GripGood, facts};
  if (quality.held_fraction < grip.min_held_fraction)
    return TaskEvent{Event::GripBad,
                     fmt::format("held at {:.2f} of what was asked (limit {:.2f}): not lifted; {}",
                                 quality.held_fraction, grip.min_held_fraction, facts)};
  if (auto weak = too_weak(quality)) return TaskEvent{Event::GripBad, *weak + "; " + facts};
  return TaskEvent{Event::GripGood, facts};
}

std::optional<TaskEvent> GripPhase::await_ready() {
  const hal::HandState& hand = c_.readings.hand;
  object_.update();
  c_.doing = "watches whether the partner is ready";
  if (!hand.held) return TaskEvent{Event::HandEmpty, "the hand has lost the object"};
  if (hand.hot) return TaskEvent{Event::GripBad, hand.warning.str()};
  if (object_.partner_lifts_first()) {
    c_.role = LiftController::Role::Follow;
    return TaskEvent{Event::PartnerReady,
                     fmt::format("the partner lifts already, by {:.0f} mm: the robot follows",
                                 1e3 * object_.partner_rise_m())};
  }
  if (c_.readings.frame &&
      (!object_.motion() || std::abs(object_.partner_rise_m()) < c_.config.task.lift.leader_rise_m))
    if (auto gone = let_go()) return gone;
  if (c_.in_state_s() > c_.config.task.grip.ready_timeout_s)
    return TaskEvent{Event::TimeOut, "the partner does not come to rest"};
  if (!partner_holds()) return std::nullopt;
  const double ready_s = c_.config.task.ready_s;
  const bool soon = c_.in_state_s() >= ready_s - c_.config.task.intent_lead_s;
  if (!soon || !c_.may_begin(Motion::Lift) || c_.in_state_s() < ready_s) return std::nullopt;
  c_.role = LiftController::Role::Lead;
  return TaskEvent{c_.config.test_lift.on ? Event::TestDue : Event::PartnerReady,
                   fmt::format("the partner has held still for {:.1f} s: the robot leads", c_.in_state_s())};
}

}  // namespace colift::control
