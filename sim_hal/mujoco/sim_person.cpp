#include "sim_hal/mujoco/sim_person.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "sim_hal/synthetic/person.hpp"

namespace colift::sim_hal {
namespace {

constexpr double kShoulders_m = 0.36;  // from joint to joint
constexpr double kHand_m = 0.16;       // what lies nearer to the contact than this is the hand
constexpr double kWithdrawn_m = 0.25, kStepBack_m = 0.30, kWalk_m = 1.6;
constexpr double kClear_m = 0.03;  // of body and arm from anything else
constexpr double kWalkUp_s = 1.0, kLetGo_s = 0.4, kStoodBack = 0.5;

Vec3 horizontal(const Vec3& v) {
  const Vec3 h(v.x(), v.y(), 0.0);
  return h.norm() > 1e-9 ? Vec3(h.normalized()) : Vec3(Vec3::UnitX());
}

double smooth(double x) {
  const double t = std::clamp(x, 0.0, 1.0);
  return t * t * (3.0 - 2.0 * t);
}

/// Shoulder from the contact for somebody who stands in a direction; stooping or squatting for low contacts.
Vec3 shoulder(const Vec3& contact, const Vec3& direction, double reach_m) {
  constexpr double kRise_m = 0.38, kLowest_m = 0.60, kHighest_m = 1.42, kApart_m = 0.30;
  const double dz = std::clamp(contact.z() + kRise_m, kLowest_m, kHighest_m) - contact.z();
  const double apart = std::sqrt(std::max(reach_m * reach_m - dz * dz, kApart_m * kApart_m));
  return apart * direction + Vec3(0, 0, dz);
}

Posture stand(const Vec3& shoulder_W, const Vec3& facing) {
  Posture p;
  p.facing = facing;
  p.right_shoulder = shoulder_W;
  p.left_shoulder = shoulder_W - kShoulders_m * facing.cross(Vec3::UnitZ());
  return p;
}

/// Smallest gap between body and arm and anything solid; the hand itself may touch.
double clearance(const World& world, const PartnerFigure& figure) {
  World body;
  const Grip grip = find_grip(world, figure.contact_W, figure.contact_W + *figure.shoulder_W);
  Posture posture = stand(figure.contact_W + *figure.shoulder_W, -horizontal(*figure.shoulder_W));
  posture.right_wrist = grip.wrist();
  add_person(body, posture);
  double smallest = std::numeric_limits<double>::infinity();
  for (const Shape& limb : body.shapes) {
    const double half = limb.kind == Shape::Kind::Capsule ? 0.5 * limb.size[1] : 0.0;
    for (int i = -4; i <= 4; ++i) {
      const Vec3 p = limb.X_WS.translation() + 0.25 * i * half * limb.X_WS.linear().col(2);
      if ((p - figure.contact_W).norm() < kHand_m) continue;
      for (const Label label : {Label::Target, Label::Clutter, Label::Wall})
        smallest = std::min(smallest, distance(world, label, p) - limb.size[0]);
    }
  }
  return smallest;
}

}  // namespace

PartnerFigure place_partner(const World& world, const Vec3& contact_W, const Vec3& outward_W) {
  PartnerFigure best;
  double best_clearance = -std::numeric_limits<double>::infinity();
  const Vec3 outward = horizontal(outward_W);
  for (const double turn : {0.0, 0.3, -0.3, 0.6, -0.6, 0.9, -0.9, 1.3, -1.3})
    for (const double reach : {0.57, 0.62}) {
      PartnerFigure figure;
      figure.contact_W = contact_W;
      figure.outward_W = outward;
      figure.shoulder_W = shoulder(contact_W, Eigen::AngleAxisd(turn, Vec3::UnitZ()) * outward, reach);
      const double clear = clearance(world, figure);
      if (clear >= kClear_m) return figure;
      if (clear > best_clearance) best = figure, best_clearance = clear;
    }
  return best;
}

std::optional<Vec3> step_aside(const World& world, const PartnerFigure& figure, const Vec3& direction_W) {
  if (!figure.shoulder_W) return std::nullopt;
  const Vec3 from = *figure.shoulder_W;
  const double side = from.cross(direction_W).z();
  if (std::abs(side) < 1e-6) return std::nullopt;
  const double clear_now = clearance(world, figure);
  for (const double turn : {1.0, 0.8, 0.6, 0.4}) {
    PartnerFigure there = figure;
    there.shoulder_W = Eigen::AngleAxisd(std::copysign(turn, side), Vec3::UnitZ()) * from;
    if (clearance(world, there) >= std::min(kClear_m, clear_now)) return there.shoulder_W;
  }
  return std::nullopt;
}

Vec3 turned(const Vec3& from, const Vec3& to, double part) {
  const double angle =
      std::atan2(from.x() * to.y() - from.y() * to.x(), from.x() * to.x() + from.y() * to.y());
  return Eigen::AngleAxisd(smooth(part) * angle, Vec3::UnitZ()) * from;
}

void add_partner(World& world, const PartnerFigure& figure) {
  if (!(figure.presence > 0.0)) return;
  const Vec3 from = figure.shoulder_W ? *figure.shoulder_W
                                      : *place_partner(world, figure.contact_W, figure.outward_W).shoulder_W;
  const Vec3 away = horizontal(from);
  const double reach = smooth((figure.presence - kStoodBack) / (1.0 - kStoodBack));
  const double ramp = smooth(figure.presence / kStoodBack);
  Grip grip = find_grip(world, figure.contact_W, figure.contact_W + from);
  const Vec3 body = figure.contact_W + from + ((1.0 - reach) * kStepBack_m + (1.0 - ramp) * kWalk_m) * away;
  const Vec3 facing = -away;
  Posture posture = stand(body, facing);

  // out of the grip and outwards, so that fingers leave a rim and a bar alike
  const Vec3 back = (grip.out + away).norm() > 0.1 ? Vec3((grip.out + away).normalized()) : away;
  const Vec3 reached = grip.at + (1.0 - reach) * kWithdrawn_m * back;
  const Vec3 carried = body + Vec3(0, 0, -0.45) + 0.12 * facing;
  grip.at = ramp * reached + (1.0 - ramp) * carried;
  posture.right_wrist = grip.wrist();
  add_hand(world, grip);
  if (figure.second_W) {
    const std::size_t first = world.shapes.size();
    const Grip second = find_grip(world, *figure.second_W, posture.left_shoulder);
    posture.left_wrist = second.wrist();
    add_hand(world, second);
    for (std::size_t i = first; i < world.shapes.size(); ++i) world.shapes[i].left = true;
  }
  add_person(world, posture);
}

double presence_at(double since_arrival_s, std::optional<double> since_let_go_s, bool leaves) {
  const double arrived = std::clamp(1.0 + since_arrival_s / kWalkUp_s, 0.0, 1.0);
  if (!since_let_go_s || *since_let_go_s < 0.0) return arrived;
  const double drawn_back = 1.0 - (1.0 - kStoodBack) * std::min(*since_let_go_s / kLetGo_s, 1.0);
  const double gone = leaves ? kStoodBack * std::max(*since_let_go_s - kLetGo_s, 0.0) / kWalkUp_s : 0.0;
  return std::min(arrived, drawn_back) - gone;
}

}  // namespace colift::sim_hal
