#include "planner/hand/hand_model.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "hal/types/units.hpp"

namespace colift::planner {
namespace {

/// Links in the plane of the finger: radius from the middle and height above the palm.
struct PlanarFinger {
  double inner_r, inner_z, inner_angle;
  double outer_r, outer_z, outer_angle;
};

PlanarFinger planar(const FingerGeometry& f, double q_rad) {
  const double bend = q_rad + hal::deg_to_rad(f.outer_bend_deg) + f.coupling * q_rad;
  const double ci = std::cos(q_rad), si = std::sin(q_rad);
  const double co = std::cos(bend), so = std::sin(bend);
  const double joint_r = f.joint_radius_m + f.inner_length_m * ci, joint_z = f.inner_length_m * si;
  return {f.joint_radius_m + 0.5 * f.inner_length_m * ci, 0.5 * f.inner_length_m * si,           q_rad,
          joint_r + 0.5 * f.outer_length_m * co,          joint_z + 0.5 * f.outer_length_m * so, bend};
}

/// Half extent along the radius of a link's box.
double half_radius(double half_length, double half_thickness, double angle) {
  return half_length * std::abs(std::cos(angle)) + half_thickness * std::abs(std::sin(angle));
}

}  // namespace

std::vector<HandCuboid> HandModel::bh8_282_cuboids() {
  return {{"palm", {0.0, 0.0, -0.0295}, {0.089, 0.089, 0.059}},
          {"knuckle of finger 1", {-0.025, -0.042, -0.012}, {0.0246, 0.044, 0.043}},
          {"knuckle of finger 2", {0.025, -0.042, -0.012}, {0.0246, 0.044, 0.043}},
          {"knuckle of finger 3", {0.0, 0.042, -0.012}, {0.0246, 0.044, 0.043}}};
}

std::vector<HandFinger> HandModel::bh8_282_fingers() {
  return {{"finger 1", -0.025, -1}, {"finger 2", 0.025, -1}, {"finger 3", 0.0, 1}};
}

hal::Result<> check_hand(const HandModel& hand) {
  const auto wrong = [&](std::string text) {
    return hal::failure(hal::ErrorCode::BadConfig, hand.name, text);
  };
  int up = 0, down = 0;
  for (const HandFinger& finger : hand.fingers) {
    if (finger.side != 1 && finger.side != -1) {
      return wrong(fmt::format("{}: side is {}, expected 1 or -1", finger.part, finger.side));
    }
    (finger.side > 0 ? up : down)++;
  }
  if (up == 0 || down == 0) {
    return wrong(
        fmt::format("{} fingers at +Hy and {} at -Hy; closing needs at least one on each side", up, down));
  }
  const double q_open = hal::deg_to_rad(hand.finger.open_deg);
  const double widest = 2.0 * half_gap_at(hand, q_open);
  if (widest < hand.opening_m) {
    return wrong(fmt::format("opening_m is {:.3f}, but the open fingers leave only {:.3f} m between them",
                             hand.opening_m, widest));
  }
  if (2.0 * half_gap_at(hand, hand.finger.closed_deg * hal::kRadPerDeg) > 0.0)
    return wrong("the fingers do not meet when they close");
  return {};
}

Pose hand_pose(const GraspCandidate& candidate, const HandModel& hand) {
  Pose X_WH = Pose::Identity();
  const Vec3 z = candidate.approach.normalized();
  const Vec3 y = (candidate.closing - z * z.dot(candidate.closing)).normalized();
  X_WH.linear().col(0) = y.cross(z);
  X_WH.linear().col(1) = y;
  X_WH.linear().col(2) = z;
  X_WH.translation() = candidate.position - hand.gap(candidate) * z;
  return X_WH;
}

FingerPose finger_at(const HandModel& hand, const HandFinger& finger, double q_rad) {
  const FingerGeometry& f = hand.finger;
  const PlanarFinger p = planar(f, q_rad);
  const double s = finger.side;
  const HandBox inner{finger.x_m,
                      s * p.inner_r,
                      p.inner_z,
                      0.5 * f.inner_width_m,
                      0.5 * f.inner_length_m + f.inner_overhang_m,
                      f.half_thickness_m,
                      s * std::cos(p.inner_angle),
                      std::sin(p.inner_angle)};
  const HandBox outer{finger.x_m,
                      s * p.outer_r,
                      p.outer_z,
                      0.5 * f.outer_width_m,
                      0.5 * f.outer_length_m,
                      f.half_thickness_m,
                      s * std::cos(p.outer_angle),
                      std::sin(p.outer_angle)};
  return {inner, outer};
}

double half_gap_at(const HandModel& hand, double q_rad) {
  const FingerGeometry& f = hand.finger;
  const PlanarFinger p = planar(f, q_rad);
  const double outer = p.outer_r - half_radius(0.5 * f.outer_length_m, f.half_thickness_m, p.outer_angle);
  // the inner link's root never leaves the knuckle, so only its far half can be the innermost part
  const double joint =
      f.joint_radius_m + f.inner_length_m * std::cos(q_rad) - f.half_thickness_m * std::sin(q_rad);
  return std::min(outer, joint);
}

PadContact contact_at_width(const HandModel& hand, double width_m) {
  // regula falsi, in the form that halves the weight of an end that stays (Illinois)
  double low = hand.finger.open_deg * hal::kRadPerDeg, high = hand.finger.closed_deg * hal::kRadPerDeg;
  double at_low = half_gap_at(hand, low) - 0.5 * width_m, at_high = half_gap_at(hand, high) - 0.5 * width_m;
  if (at_low <= 0.0) at_high = 0.0, high = low;
  for (int i = 0, side = 0; i < 60 && high - low > 1e-12 && at_low > 1e-13; ++i) {
    const double share = at_high < 0.0 ? at_low / (at_low - at_high) : 0.5;
    const double q = low + share * (high - low), value = half_gap_at(hand, q) - 0.5 * width_m;
    if (value > 0.0) {
      low = q, at_low = value;
      if (side > 0) at_high *= 0.5;
      side = 1;
    } else {
      high = q, at_high = value;
      if (side < 0) at_low *= 0.5;
      side = -1;
      if (value > -1e-13) low = q, at_low = 0.0;
    }
  }
  const FingerGeometry& f = hand.finger;
  const PlanarFinger p = planar(f, low);
  // beyond parallel the fingertip touches, before it the root of the pad; the middle of the outer link lies
  // between
  const double along = std::cos(p.outer_angle) < 0.0 ? 0.5 : -0.5;
  const double height = p.outer_z + along * f.outer_length_m * std::sin(p.outer_angle) +
                        f.half_thickness_m * std::cos(p.outer_angle);
  return {low, height};
}

double stopped_angle(const HandModel& hand, const GraspCandidate& candidate, double between_m) {
  if (candidate.kind != GraspKind::Wrap)
    return contact_at_width(hand, candidate.width + 2.0 * between_m).q_rad;
  const double middle = hand.gap(candidate) + 0.5 * candidate.width;
  const double radius = 0.5 * candidate.width + between_m;
  const auto meets = [&](double q) {
    const FingerPose pose = finger_at(hand, HandFinger{"", 0.0, 1}, q);
    const auto near = [&](const HandBox& link) {
      const double dy = -link.cy, dz = middle - link.cz;
      const double along = std::abs(dy * link.ey + dz * link.ez) - link.h1;
      const double aside = std::abs(dz * link.ey - dy * link.ez) - link.h2;
      return std::hypot(std::max(along, 0.0), std::max(aside, 0.0)) <= radius;
    };
    return near(pose.inner) || near(pose.outer);
  };
  constexpr double kStep_rad = 0.5 * hal::kRadPerDeg;  // resolution of the result
  double q = hand.finger.open_deg * hal::kRadPerDeg;
  const double closed = hand.finger.closed_deg * hal::kRadPerDeg;
  while (q < closed && !meets(q)) q += kStep_rad;
  return q;
}

double HandModel::largest_gap(const GraspCandidate& c) const {
  const double behind =
      c.kind == GraspKind::Wrap ? std::max(min_hold_m, 0.5 * c.width - wrap_margin_m) : min_hold_m;
  return contact_at_width(*this, c.width).height_m - behind;
}

}  // namespace colift::planner
