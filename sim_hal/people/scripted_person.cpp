#include "sim_hal/people/scripted_person.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace colift::sim_hal {
namespace {

constexpr double kTick_s = 0.001;
constexpr double kShoulders_m = 0.36, kStanding_m = 1.42, kCrouching_m = 0.80, kSitting_m = 0.98;
constexpr double kLowest_m = 0.60, kAboveGoal_m = 0.38;  // of the shoulders
constexpr double kSettle_s = 0.6, kTurn_rad_s = 5.0, kStride_m = 1.4, kSwing_m = 0.24, kStep_m = 0.05;
constexpr double kArm_m = 0.57, kMaxLean_m = 0.40, kLegReach_m = 0.55, kAnkle_m = 0.06, kToe_m = 0.02;
constexpr double kInside_m = 0.04;  // how far under the object the tip goes
constexpr double kWaits_m = 0.10;   // how far off it waits for a gap
constexpr double kGap_m = 0.045;    // that toes and fingers need

double smooth(double x) {
  const double t = std::clamp(x, 0.0, 1.0);
  return t * t * (3.0 - 2.0 * t);
}

Vec3 flat(const Vec3& v) {
  return {v.x(), v.y(), 0.0};
}

void approach(Vec3& from, const Vec3& to, double step) {
  const Vec3 off = to - from;
  from = off.norm() <= step ? to : Vec3(from + step * off.normalized());
}

void approach(double& from, double to, double step) {
  from += std::clamp(to - from, -step, step);
}

Vec3 middle_of(const std::vector<Shape>& parts) {
  Vec3 sum = Vec3::Zero();
  for (const Shape& part : parts) sum += part.X_WS.translation();
  return parts.empty() ? sum : Vec3(sum / static_cast<double>(parts.size()));
}

/// Corners of a box, ends of a cylinder: what can be the lowest point of a part.
template <class Use>
void for_corners(const Shape& part, const Use& use) {
  for (int i = 0; i < 8; ++i) {
    Vec3 p((i & 1) != 0 ? 0.5 : -0.5, (i & 2) != 0 ? 0.5 : -0.5, (i & 4) != 0 ? 0.5 : -0.5);
    if (part.kind == Shape::Kind::Box) {
      p = p.cwiseProduct(part.size);
    } else {
      p = {2.0 * p.x() * part.size[0], 2.0 * p.y() * part.size[0], p.z() * part.size[1]};
    }
    use(Vec3(part.X_WS * p));
  }
}

/// Of the object's surface, from outside (coarse: he reaches until he touches it anyway).
Vec3 nearest_on(const std::vector<Shape>& parts, const Vec3& from) {
  Vec3 p = from;
  const Vec3 inwards = middle_of(parts) - from;
  constexpr int kSteps = 200;
  for (int i = 0; i < kSteps; ++i) {
    p = from + inwards * (static_cast<double>(i) / kSteps);
    for (const Shape& part : parts)
      if (distance(part, p) < 0.01) return p;
  }
  return p;
}

}  // namespace

ScriptedPerson::ScriptedPerson(const ScenarioPerson& script) : script_(script) {
  for (std::size_t i = 1; i < script_.path.size(); ++i)
    length_m_ += (script_.path[i] - script_.path[i - 1]).norm();
  Vec3 direction = Vec3::Zero();
  at_ = on_path(0.0, &direction);
  if (direction.norm() > 0.0) facing_ = direction;
}

Vec3 ScriptedPerson::on_path(double walked_m, Vec3* direction) const {
  const auto& path = script_.path;
  Eigen::Vector2d at = path.front();
  for (std::size_t i = 1; i < path.size(); ++i) {
    const Eigen::Vector2d leg = path[i] - path[i - 1];
    const double length = leg.norm();
    if (length < 1e-9) continue;
    *direction = Vec3(leg.x(), leg.y(), 0.0) / length;
    if (walked_m <= length) {
      at = path[i - 1] + leg * (walked_m / length);
      return {at.x(), at.y(), 0.0};
    }
    walked_m -= length;
    at = path[i];
  }
  return {at.x(), at.y(), 0.0};
}

void ScriptedPerson::task_state(const std::string& name, double t_s) {
  if (script_.in_state.empty() || script_.in_state != name) return;
  script_.in_state.clear();
  script_.enters_s += t_s;
}

void ScriptedPerson::turn_to(const Vec3& direction) {
  if (direction.norm() < 1e-6) return;
  const double now = std::atan2(facing_.y(), facing_.x());
  const double off = std::remainder(std::atan2(direction.y(), direction.x()) - now, 2.0 * std::numbers::pi);
  const double turned = now + std::clamp(off, -kTurn_rad_s * kTick_s, kTurn_rad_s * kTick_s);
  facing_ = {std::cos(turned), std::sin(turned), 0.0};
}

// below the corner of the object's underside that is nearest to him, once there is a gap
Vec3 ScriptedPerson::under(const PersonView& view) const {
  double lowest = std::numeric_limits<double>::infinity(), nearest = lowest;
  const auto each = [&](const auto& use) {
    for (const Shape& part : *view.object) for_corners(part, use);
  };
  each([&](const Vec3& p) { lowest = std::min(lowest, p.z()); });
  Vec3 corner = at_;
  each([&](const Vec3& p) {
    const double away = flat(p - at_).norm();
    if (p.z() > lowest + 0.02 || away >= nearest) return;
    nearest = away;
    corner = p;
  });
  const Vec3 inwards = flat(corner - at_).normalized();
  const bool gap = corner.z() > kGap_m;
  const Vec3 place = corner + (gap ? kInside_m : -kWaits_m) * inwards;
  return {place.x(), place.y(), std::max(0.5 * corner.z(), kToe_m)};
}

std::optional<Vec3> ScriptedPerson::goal(const PersonView& view) const {
  if (script_.action != "reach") return std::nullopt;
  if (script_.reach_to == "point") return script_.point;
  if (script_.reach_to == "robot-hand") return view.palm_W;
  if (script_.reach_to == "between-fingers") return view.between_fingers_W;
  if (view.object == nullptr || view.object->empty()) return std::nullopt;
  if (script_.reach_to == "under-object") return under(view);
  return nearest_on(*view.object, at_ + Vec3(0, 0, 1.0));
}

Vec3 ScriptedPerson::resting_tip() const {
  const Vec3 right = facing_.cross(Vec3::UnitZ());
  if (script_.with_foot) return at_ + 0.10 * right + kAnkleToToe_m * facing_ + Vec3(0, 0, kToe_m);
  return at_ + (0.5 * kShoulders_m + 0.05) * right + 0.10 * facing_ + Vec3(0, 0, 0.80);
}

void ScriptedPerson::reach(const PersonView& view, bool blocked) {
  const bool at_end = walked_m_ >= length_m_ && settled_ > 0.0;
  const auto to = goal(view);
  if (!to || !at_end) {
    tip_W_.reset();
    lean_m_ = 0.0;
    goal_z_m_ = kStanding_m;
    return;
  }
  if (!tip_W_) tip_W_ = resting_tip();
  goal_z_m_ = to->z();
  if (blocked) return;
  Vec3 within = *to;
  if (script_.with_foot) {
    const Vec3 hip = at_ + 0.10 * facing_.cross(Vec3::UnitZ());
    Vec3 off = flat(*to - hip);
    const double far = kLegReach_m + kAnkleToToe_m;
    if (off.norm() > far) off *= far / off.norm();
    within = hip + off + Vec3(0, 0, kToe_m);
  } else {
    // he leans as far as he has to
    const double apart = flat(*to - at_).norm() - (kArm_m + kHandLength_m - 0.12);
    approach(lean_m_, std::clamp(apart, 0.0, kMaxLean_m), kTick_s * script_.hand_speed);
  }
  approach(*tip_W_, within, kTick_s * script_.hand_speed);
}

void ScriptedPerson::tick(double t_s, const PersonView& view, bool walk_blocked, bool reach_blocked) {
  if (gone_ || !script_.in_state.empty() || t_s < script_.enters_s) return;
  present_ = true;
  const bool leaves = script_.leaves_s && t_s >= *script_.leaves_s;
  // who has walked into something stops there and leans on it; he does not walk through what yields
  stopped_ = (stopped_ || walk_blocked) && !leaves;
  const bool at_end = walked_m_ >= length_m_;
  const bool posed = script_.action != "walk" && script_.action != "stand";
  bool walks = false;
  if (leaves) {
    approach(settled_, 0.0, kTick_s / kSettle_s);
    walks = settled_ <= 0.0 && !walk_blocked;
    if (walks) walked_m_ -= kTick_s * script_.speed;
    if (walked_m_ <= 0.0 && walks) {
      gone_ = true;
      present_ = false;
      return;
    }
  } else if (!at_end) {
    walks = !stopped_;
    if (walks) walked_m_ = std::min(walked_m_ + kTick_s * script_.speed, length_m_);
  } else if (posed) {
    approach(settled_, 1.0, kTick_s / kSettle_s);
  }
  approach(stride_, walks ? 1.0 : 0.0, kTick_s / 0.3);
  Vec3 direction = Vec3::Zero();
  at_ = on_path(std::max(walked_m_, 0.0), &direction);
  const bool looks = at_end && !leaves;
  if (looks && script_.action == "reach") {
    if (const auto to = goal(view)) turn_to(flat(*to - at_));
  } else if (looks && length_m_ == 0.0 && view.object != nullptr) {
    turn_to(flat(middle_of(*view.object) - at_));
  } else {
    turn_to(leaves ? Vec3(-direction) : direction);
  }
  reach(view, reach_blocked);
}

Posture ScriptedPerson::posture() const {
  const double s = smooth(settled_);
  const Vec3 right = facing_.cross(Vec3::UnitZ());
  double height = kStanding_m;
  if (script_.action == "crouch") height = kCrouching_m;
  if (script_.action == "sit") height = kSitting_m;
  if (script_.action == "reach" && !script_.with_foot)
    height = std::clamp(goal_z_m_ + kAboveGoal_m, kLowest_m, kStanding_m);
  height = kStanding_m + s * (height - kStanding_m);
  Posture p;
  p.facing = facing_;
  p.toes = true;
  const Vec3 middle = at_ + lean_m_ * facing_ + Vec3(0, 0, height - 0.2 * lean_m_);
  p.right_shoulder = middle + 0.5 * kShoulders_m * right;
  p.left_shoulder = middle - 0.5 * kShoulders_m * right;
  if (script_.action == "sit") {
    p.hip = at_ + Vec3(0, 0, height - 0.50);
  } else if (lean_m_ > 0.0) {
    p.hip = at_ - 0.3 * lean_m_ * facing_ + Vec3(0, 0, std::max(height - 0.48, 0.35));
  }
  const double swing = stride_ * std::sin(2.0 * std::numbers::pi * walked_m_ / kStride_m);
  const double lift = stride_ * std::cos(2.0 * std::numbers::pi * walked_m_ / kStride_m);
  const double out = script_.action == "sit" ? 0.40 * s : 0.0;
  const auto foot = [&](double side) {
    return Vec3(at_ + side * 0.10 * right + (side * kSwing_m * swing + 0.02 + out) * facing_ +
                Vec3(0, 0, kAnkle_m + kStep_m * std::max(side * lift, 0.0)));
  };
  p.right_foot = foot(1.0);
  p.left_foot = foot(-1.0);
  if (!tip_W_) return p;
  if (script_.with_foot) {
    const Vec3 ankle = *tip_W_ - kAnkleToToe_m * facing_;
    p.right_foot = Vec3(ankle.x(), ankle.y(), tip_W_->z() + kAnkle_m - kToe_m);
    return p;
  }
  Vec3 out_of_shoulder = *tip_W_ - p.right_shoulder;
  const double far = kArm_m + kHandLength_m;
  if (out_of_shoulder.norm() > far) out_of_shoulder *= far / out_of_shoulder.norm();
  p.right_tip = p.right_shoulder + out_of_shoulder;
  p.right_wrist = *p.right_tip - kHandLength_m * out_of_shoulder.normalized();
  return p;
}

void ScriptedPerson::add_to(World& world) const {
  if (present_) add_person(world, posture());
}

}  // namespace colift::sim_hal
