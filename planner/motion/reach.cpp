#include "planner/motion/reach.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include "hal/types/units.hpp"
#include "planner/motion/straight_line.hpp"

namespace colift::planner {
namespace {

using hal::JointVector;
using hal::Pose;
using hal::Vec3;

double mm(double m) {
  return 1e3 * m;
}

const char* postures(int count) {
  return count == 1 ? "arm posture" : "arm postures";
}

}  // namespace

GraspReach::GraspReach(const hal::RobotModel& model, const ArmGeometry& arm, const PlannerConfig& config,
                       FastChecker& checker)
    : model_(model), arm_(arm), config_(config), checker_(checker) {}

std::optional<ReachRefusal> GraspReach::too_far(const Pose& X_WF, const char* where) const {
  const Vec3 shoulder(0.0, 0.0, arm_.base_to_shoulder_m);
  const Vec3 wrist = X_WF.translation() - arm_.wrist_to_flange_m * X_WF.linear().col(2);
  const double distance = (wrist - shoulder).norm();
  const double longest = arm_.upper_arm_m + arm_.forearm_m;
  if (distance > longest) {
    return ReachRefusal{fmt::format("the wrist would have to go {:.0f} mm beyond the arm's reach {}",
                                    std::max(1.0, mm(distance - longest)), where),
                        distance - longest};
  }
  const double bend = std::max(std::abs(arm_.lower_rad[3]), std::abs(arm_.upper_rad[3])) -
                      config_.limit_margin_deg * hal::kRadPerDeg;
  const double shortest =
      std::sqrt(arm_.upper_arm_m * arm_.upper_arm_m + arm_.forearm_m * arm_.forearm_m +
                2.0 * arm_.upper_arm_m * arm_.forearm_m * std::cos(std::min(bend, std::numbers::pi)));
  if (distance < shortest) {
    return ReachRefusal{
        fmt::format("the wrist would come {:.0f} mm nearer to the shoulder than the elbow bends {}",
                    std::max(1.0, mm(shortest - distance)), where),
        shortest - distance};
  }
  return std::nullopt;
}

void GraspReach::ended(Stage stage, JointPath at, Contacts contacts, double followed_m, double of_m) {
  const bool farther = !ends_.any || stage > ends_.farthest ||
                       (stage == ends_.farthest && at.empty() && followed_m > ends_.followed_m);
  const int before = ends_.any && stage == ends_.farthest ? ends_.postures : 0;
  if (farther) {
    ends_ = Ends{stage, before, std::move(at), followed_m, of_m, contacts, true};
  }
  if (stage == ends_.farthest) ends_.postures = before + 1;
}

bool GraspReach::pass(const ReachQuery& query, const Pose& X_WF, const ScoredIk& ik, GraspPosture& out) {
  const double margin = config_.limit_margin_deg * hal::kRadPerDeg;
  checker_.allow(Contacts::FingersOnTarget);
  if (!checker_.is_free(ik.q_rad)) return ended(Stage::Grasp, {ik.q_rad}, Contacts::FingersOnTarget), false;

  back_.assign(1, ik.q_rad);
  const Vec3 back = -config_.pre_grasp_m * query.X_WH.linear().col(2);
  double followed = follow_line(arm_, X_WF, back, config_.cartesian_step_m, margin,
                                config_.search.max_turn_rad_per_m, back_);
  if (followed < back.norm() - 1e-9) {
    return ended(Stage::BackLimits, {}, Contacts::None, followed, back.norm()), false;
  }
  checker_.allow(Contacts::None);
  if (!checker_.is_free(back_.back())) return ended(Stage::PreGrasp, {back_.back()}, Contacts::None), false;
  checker_.allow(Contacts::FingersOnTarget);
  for (std::size_t i = 1; i < back_.size(); ++i) {
    if (!checker_.is_free(back_[i - 1], back_[i], config_.step_rad)) {
      return ended(Stage::Approach, {back_[i - 1], back_[i]}, Contacts::FingersOnTarget), false;
    }
  }

  // the margin above the lift is there to be able to follow the partner
  lift_.assign(1, ik.q_rad);
  const double of = query.lift_m + config_.lift_margin_m;
  Pose X_WF_up = X_WF;
  X_WF_up.translation() += query.lift_m * query.up;
  followed = follow_line(arm_, X_WF, query.lift_m * query.up, config_.cartesian_step_m, margin,
                         config_.search.max_turn_rad_per_m, lift_);
  const JointVector lifted = lift_.back();
  if (followed >= query.lift_m - 1e-9) {
    followed += follow_line(arm_, X_WF_up, config_.lift_margin_m * query.up, config_.cartesian_step_m, margin,
                            config_.search.max_turn_rad_per_m, lift_);
  }
  if (followed < of - 1e-9) return ended(Stage::LiftLimits, {}, Contacts::None, followed, of), false;
  checker_.set_carry_origin(query.X_WH);
  checker_.allow(Contacts::Carrying);
  // as one line in joint space: over so short a way the hand strays by millimetres only
  if (!checker_.is_free(ik.q_rad, lift_.back(), config_.step_rad)) {
    return ended(Stage::Lift, {ik.q_rad, lift_.back()}, Contacts::Carrying), false;
  }
  out.reach = {back_.back(), ik.q_rad, lifted, ik.score};
  out.approach.assign(back_.rbegin(), back_.rend());
  return true;
}

std::vector<GraspPosture> GraspReach::find(const ReachQuery& query, std::size_t most, ReachRefusal& why) {
  std::vector<GraspPosture> found;
  const Pose X_WF = query.X_WH * model_.X_FH.inverse();
  Pose X_WF_pre = X_WF, X_WF_up = X_WF;
  X_WF_pre.translation() -= config_.pre_grasp_m * query.X_WH.linear().col(2);
  X_WF_up.translation() += (query.lift_m + config_.lift_margin_m) * query.up;
  const std::array<std::pair<const Pose*, const char*>, 3> places{
      {{&X_WF, "at the grasp"}, {&X_WF_pre, "before the grasp"}, {&X_WF_up, "at the top of the lift"}}};
  for (const auto& [pose, where] : places) {
    if (auto refusal = too_far(*pose, where)) {
      why = *std::move(refusal);
      return found;
    }
  }
  const std::vector<ScoredIk> all =
      all_ik(arm_, X_WF, config_.limit_margin_deg * hal::kRadPerDeg, config_.elbow_steps);
  if (all.empty()) {
    why = {fmt::format("no arm posture within the joint limits puts the hand there ({} elbow angles tried)",
                       config_.elbow_steps),
           std::nullopt};
    return found;
  }
  ends_ = {};
  for (const ScoredIk& ik : all) {
    const bool known = std::any_of(found.begin(), found.end(), [&](const GraspPosture& other) {
      return joint_distance(other.reach.grasp_rad, ik.q_rad) < config_.search.same_posture_rad;
    });
    if (known) continue;
    GraspPosture posture;
    if (pass(query, X_WF, ik, posture)) {
      found.push_back(std::move(posture));
      if (found.size() == most) break;
    } else if (ends_.postures == 1 && ends_.farthest == Stage::Grasp && found.empty()) {
      // where the hand itself cannot be, no arm posture helps
      const Touch touch = touch_along(ends_.at, ends_.contacts);
      if (hand_alone(touch)) {
        why = {fmt::format("{} at the grasp, whatever the arm does", touch.text()), touch.depth_m};
        return found;
      }
    }
  }
  if (found.empty()) why = explain();
  return found;
}

Touch GraspReach::touch_along(const JointPath& way, Contacts contacts) const {
  checker_.allow(contacts);
  Touch touch;
  for (std::size_t i = 0; i < way.size() && touch.with == Touch::With::Nothing; ++i) {
    if (i == 0) {
      touch = checker_.what_touches(way[0]);
      continue;
    }
    const int steps =
        std::max(1, static_cast<int>(std::ceil(joint_distance(way[i - 1], way[i]) / config_.step_rad)));
    for (int k = 1; k <= steps && touch.with == Touch::With::Nothing; ++k) {
      touch = checker_.what_touches(way[i - 1] + (static_cast<double>(k) / steps) * (way[i] - way[i - 1]));
    }
  }
  return touch;
}

bool GraspReach::hand_alone(const Touch& touch) const {
  if (touch.with != Touch::With::Obstacle && touch.with != Touch::With::Target &&
      touch.with != Touch::With::Ground) {
    return false;
  }
  for (std::size_t i = 0; i < model_.links.size(); ++i) {
    if (model_.links[i].name == touch.part) return model_.in_hand(static_cast<int>(i));
  }
  return false;
}

ReachRefusal GraspReach::explain() const {
  const auto limits = [&](const char* what) {
    return ReachRefusal{
        fmt::format("{} the arm meets its limits after {:.0f} of {:.0f} mm in the best of {} {}", what,
                    mm(ends_.followed_m), mm(ends_.of_m), ends_.postures, postures(ends_.postures)),
        ends_.of_m - ends_.followed_m};
  };
  if (ends_.farthest == Stage::BackLimits) return limits("going straight back from the grasp");
  if (ends_.farthest == Stage::LiftLimits) return limits("lifting");

  const char* where = "";
  switch (ends_.farthest) {
    case Stage::Grasp:
      where = "at the grasp";
      break;
    case Stage::PreGrasp:
      where = "before the grasp";
      break;
    case Stage::Approach:
      where = "on the straight approach to the grasp";
      break;
    default:
      where = "during the lift";
      break;
  }
  const Touch touch = touch_along(ends_.at, ends_.contacts);
  return {fmt::format("{} {} ({} {} tried get that far, this is the best)", touch.text(), where,
                      ends_.postures, postures(ends_.postures)),
          touch.depth_m};
}

}  // namespace colift::planner
