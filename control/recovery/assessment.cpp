#include "control/recovery/assessment.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "control/lift/load_estimator.hpp"
#include "hal/types/units.hpp"

namespace colift::control {
namespace {

constexpr double kStopFraction = 0.94;  // of a full stroke: a finger that met nothing

void assess_arm(Assessment& a, const std::vector<hal::ArmState>& states, const hal::JointVector& home_rad,
                const RecoveryConfig& config) {
  if (states.empty() || !states.back().q_rad.allFinite()) {
    a.arm_words = "unknown: it does not report its position";
    return;
  }
  const hal::JointVector& q = states.back().q_rad;
  double moved = 0.0;
  for (const hal::ArmState& s : states) moved = std::max(moved, (s.q_rad - q).cwiseAbs().maxCoeff());
  int joint = 0;
  const double off = (q - home_rad).cwiseAbs().maxCoeff(&joint);
  if (!(moved <= config.still_rad)) {
    a.arm = Assessment::Arm::Moving;
    a.arm_words = fmt::format("is moving, by {:.1f} deg", hal::rad_to_deg(moved));
  } else if (off <= config.home_rad) {
    a.arm = Assessment::Arm::AtHome;
    a.arm_words = "at rest, at home";
  } else {
    a.arm = Assessment::Arm::Away;
    a.arm_words = fmt::format("at rest, away from home: A{} by {:.0f} deg", joint + 1, hal::rad_to_deg(off));
  }
}

void assess_hand(Assessment& a, const std::optional<hal::HandState>& hand, const planner::HandModel& model,
                 const RecoveryConfig& config) {
  if (!hand) {
    a.hand_words = "unknown: it does not answer";
    return;
  }
  const auto& q = hand->finger_rad;
  const auto [least, most] = std::minmax_element(q.begin(), q.end());
  const std::string angles = fmt::format("fingers at {:.0f}, {:.0f}, {:.0f} deg", hal::rad_to_deg(q[0]),
                                         hal::rad_to_deg(q[1]), hal::rad_to_deg(q[2]));
  if (hand->held) {
    a.hand = Assessment::Hand::Holds;
    a.hand_words = "closed on an object, or taken for it: " + angles;
  } else if (*most < config.open_tolerance_rad) {
    a.hand = Assessment::Hand::Open;
    a.hand_words = "open";
  } else if (*least > kStopFraction * hal::deg_to_rad(model.finger.closed_deg)) {
    a.hand = Assessment::Hand::Closed;
    a.hand_words = "closed to its stops: " + angles;
  } else {
    a.hand = Assessment::Hand::Between;
    a.hand_words = "neither open nor closed, it may hold an object: " + angles;
  }
}

void assess_load(Assessment& a, const std::vector<hal::ArmState>& states, const hal::RobotModel& model) {
  double sum_n = 0.0;
  int count = 0;
  for (const hal::ArmState& s : states) {
    if (!s.tau_external_nm.allFinite() || !s.q_rad.allFinite()) continue;
    sum_n -= palm_wrench(model, s.q_rad, s.tau_external_nm).force.z();
    ++count;
  }
  if (count == 0) {
    a.load_words = "unknown: the arm reports no torques";
    return;
  }
  a.load_n = sum_n / count;
  a.load_words = fmt::format("{:.0f} N at the palm (not tared)", *a.load_n);
}

}  // namespace

Assessment assess(const std::vector<hal::ArmState>& arm, const std::optional<hal::HandState>& hand,
                  const hal::JointVector& home_rad, const hal::RobotModel& model,
                  const planner::HandModel& hand_model, const RecoveryConfig& config) {
  Assessment a;
  assess_arm(a, arm, home_rad, config);
  assess_hand(a, hand, hand_model, config);
  assess_load(a, arm, model);
  return a;
}

}  // namespace colift::control
