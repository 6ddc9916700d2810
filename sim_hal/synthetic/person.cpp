#include "sim_hal/synthetic/person.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>
#include <vector>

namespace colift::sim_hal {
namespace {

constexpr double kUpperArm_m = 0.31, kForearm_m = 0.27, kThigh_m = 0.43, kShin_m = 0.45;
constexpr double kFinger_m = 0.009, kThumb_m = 0.010;  // radii
constexpr double kSkin_m = 0.45;  // reflectivity of skin and light cloth in the near infrared

void add(World& world, Shape shape, BodyPart part, bool left = false) {
  shape.label = Label::Partner;
  shape.reflectivity = kSkin_m;
  shape.part = part;
  shape.left = left;
  world.shapes.push_back(shape);
}
void add_limb(World& world, const Vec3& from, const Vec3& to, double radius, BodyPart part = BodyPart::Hand,
              bool left = false) {
  add(world, capsule(from, to, radius, Label::Partner), part, left);
}

// the joint between two segments that reach from one point to another, bent towards `bend`
Vec3 joint(const Vec3& from, const Vec3& to, double first, double second, const Vec3& bend) {
  const Vec3 span = to - from;
  const double d = span.norm();
  if (d < 1e-6) return from + first * bend;
  const Vec3 axis = span / d;
  // further apart than the limb is long: stretched, the model does not tear
  const double along = d >= first + second
                           ? d * first / (first + second)
                           : std::clamp((d * d + first * first - second * second) / (2 * d), -first, first);
  const double aside = d >= first + second ? 0.0 : std::sqrt(std::max(first * first - along * along, 0.0));
  Vec3 side = bend - axis * axis.dot(bend);
  side = side.norm() > 1e-6 ? side.normalized() : hal::tangents(axis).first;
  return from + along * axis + aside * side;
}

void add_arm(World& world, const Vec3& shoulder, const Vec3& wrist, const Vec3& outwards, bool left) {
  const Vec3 elbow = joint(shoulder, wrist, kUpperArm_m, kForearm_m, outwards * 0.6 - Vec3::UnitZ());
  add_limb(world, shoulder, elbow, 0.048, BodyPart::UpperArm, left);
  add_limb(world, elbow, wrist, 0.034, BodyPart::LowerArm, left);
}

void add_leg(World& world, const Vec3& hip, const std::optional<Vec3>& ankle, const Posture& p, bool left) {
  const Vec3 foot = ankle.value_or(Vec3(hip.x(), hip.y(), 0.06) + 0.06 * p.facing);
  const Vec3 knee = joint(hip, foot, kThigh_m, kShin_m, p.facing);
  add_limb(world, hip, knee, 0.075, BodyPart::Thigh, left);
  add_limb(world, knee, foot, 0.05, BodyPart::LowerLeg, left);
  if (!p.toes) {
    add_limb(world, foot - 0.06 * p.facing, foot + 0.16 * p.facing, 0.045, BodyPart::Foot, left);
    return;
  }
  constexpr double kShoe_m = 0.035, kToes_m = 0.020, kSole_m = 0.06;  // radii; sole below the ankle
  const Vec3 heel = foot - Vec3(0, 0, kSole_m - kShoe_m);
  const Vec3 ball = foot - Vec3(0, 0, kSole_m - kToes_m);
  add_limb(world, heel - 0.05 * p.facing, heel + 0.09 * p.facing, kShoe_m, BodyPart::Foot, left);
  add_limb(world, ball + 0.10 * p.facing, ball + (kAnkleToToe_m - kToes_m) * p.facing, kToes_m,
           BodyPart::Foot, left);
}

// fingers stretched, palm down, as somebody reaches for something
void add_reaching_hand(World& world, const Vec3& wrist, const Vec3& tip) {
  const Vec3 along = (tip - wrist).normalized();
  Vec3 across = along.cross(Vec3::UnitZ());
  across = across.norm() > 1e-6 ? across.normalized() : Vec3(Vec3::UnitX());
  for (const double side : {-0.020, 0.020})
    add_limb(world, wrist + side * across, wrist + side * across + 0.070 * along, 0.018);
  for (const double side : {-0.024, 0.0, 0.024})
    add_limb(world, wrist + side * across + 0.075 * along,
             wrist + side * across + (kHandLength_m - 0.010) * along, 0.010);
}

// a box with given axes
void add_block(World& world, const Vec3& center, const Vec3& x, const Vec3& y, const Vec3& size) {
  Shape s = box(center, size, 0.0, Label::Partner);
  s.X_WS.linear() << x, y, x.cross(y);
  add(world, s, BodyPart::Hand);
}

// the face of a box that a point lies on, as axis and side
struct OnFace {
  int axis;
  double side;
};

std::vector<OnFace> faces_at(const Vec3& p, const Vec3& half) {
  constexpr double kOn_m = 0.004;
  std::vector<OnFace> on;
  for (int axis = 0; axis < 3; ++axis)
    if (half[axis] - std::abs(p[axis]) < kOn_m) on.push_back({axis, p[axis] < 0 ? -1.0 : 1.0});
  return on;
}

Grip grip_on_round(const Shape& bar, const Vec3& contact) {
  Grip g;
  g.kind = Grip::Kind::Wrap;
  g.along = bar.X_WS.linear().col(2);
  const Vec3 from_axis = contact - bar.X_WS.translation();
  const Vec3 radial = from_axis - g.along * g.along.dot(from_axis);
  g.out = radial.norm() > 1e-6 ? radial.normalized() : hal::tangents(g.along).first;
  g.at = contact;
  g.across = g.out.cross(g.along);
  g.thickness = 2 * bar.size[0];
  return g;
}

// the arm comes from the side where the thumb is not; from straight behind, a bar that rolls by a fraction of
// a degree turns no hand around
Grip with_thumb_away(Grip g, const Vec3& arm) {
  constexpr double kBehind = 0.05;  // sine
  if (g.across.dot(arm) > kBehind * arm.norm()) g.across = -g.across, g.along = -g.along;
  return g;
}

// a handle or rung that a hand takes by the middle of one of its sides: the hand goes round it
std::optional<Grip> grip_on_bar(const Shape& b, const Vec3& contact, const std::vector<OnFace>& on) {
  constexpr double kMost_m = 0.045, kMiddle_m = 0.003, kOblong = 3.0;
  int along = 0;
  b.size.maxCoeff(&along);
  if (on.size() != 1 || on.front().axis == along) return std::nullopt;
  const int face = on.front().axis, across = 3 - along - face;
  const double thick = std::max(b.size[face], b.size[across]);
  const double aside = std::abs((b.X_WS.inverse() * contact)[across]);
  if (thick > kMost_m || b.size[along] < kOblong * thick || aside > kMiddle_m) return std::nullopt;
  Grip g;
  g.kind = Grip::Kind::Wrap;
  g.at = contact;
  g.out = on.front().side * b.X_WS.linear().col(face);
  g.along = b.X_WS.linear().col(along);
  g.across = g.out.cross(g.along);
  g.thickness = thick;
  return g;
}

Grip grip_on_box(const Shape& b, const Vec3& contact, const Vec3& from) {
  constexpr double kThin_m = 0.065, kNearEdge_m = 0.03;
  const Vec3 p = b.X_WS.inverse() * contact, half = 0.5 * b.size;
  const Vec3 towards = b.X_WS.linear().transpose() * (from - contact);
  const auto world_axis = [&](const OnFace& f) { return Vec3(f.side * b.X_WS.linear().col(f.axis)); };
  Grip g;
  g.at = contact;

  int thin = 0;
  half.minCoeff(&thin);
  std::vector<OnFace> on = faces_at(p, half);
  if (auto bar = grip_on_bar(b, contact, on)) return with_thumb_away(*bar, from - contact);
  std::stable_sort(on.begin(), on.end(), [&](const OnFace& l, const OnFace& r) {
    return l.side * towards[l.axis] > r.side * towards[r.axis];
  });
  if (b.size[thin] <= kThin_m) {
    OnFace edge{-1, 1.0};
    for (const OnFace& f : on)
      if (f.axis != thin && edge.axis < 0) edge = f;
    for (int axis = 0; axis < 3 && edge.axis < 0; ++axis)  // on the flat side, but near a rim
      if (axis != thin && half[axis] - std::abs(p[axis]) < kNearEdge_m)
        edge = {axis, p[axis] < 0 ? -1.0 : 1.0};
    if (edge.axis >= 0) {
      Vec3 middle = p;
      middle[thin] = 0.0;
      middle[edge.axis] = edge.side * half[edge.axis];
      g.kind = Grip::Kind::Pinch;
      g.at = b.X_WS * middle;
      g.out = world_axis(edge);
      g.across = b.X_WS.linear().col(thin);
      // the thumb lies on top, or on the person's side of what stands upright
      const double up = g.across.z();
      if (std::abs(up) > 0.5 ? up < 0 : g.across.dot(from - contact) < 0) g.across = -g.across;
      g.along = g.across.cross(g.out);
      g.thickness = b.size[thin];
      return g;
    }
  }
  if (on.empty()) on.push_back({2, 1.0});
  g.out = world_axis(on.front());
  if (on.size() > 1) {
    // over an edge: the palm goes on the steeper face, the fingers on the other
    OnFace palm = on[0], top = on[1];
    if (world_axis(palm).z() > world_axis(top).z()) std::swap(palm, top);
    g.kind = Grip::Kind::Hook;
    g.out = world_axis(palm);
    g.across = world_axis(top);
  } else {
    // the fingers point away from the arm
    Vec3 away = contact - from;
    away -= g.out * g.out.dot(away);
    g.across = away.norm() > 1e-6 ? Vec3(-away.normalized()) : hal::tangents(g.out).first;
  }
  g.along = g.across.cross(g.out);
  return g;
}

void add_pinching_hand(World& world, const Grip& g) {
  const auto p = [&](double out, double along, double across) {
    return Vec3(g.at + out * g.out + along * g.along + across * g.across);
  };
  const double half = 0.5 * g.thickness;
  add_block(world, p(0.036, 0, 0), g.out, g.along, {0.070, 0.082, std::max(0.030, g.thickness + 0.006)});
  add_limb(world, p(0.040, -0.034, half + 0.012), p(-0.010, -0.028, half + kThumb_m), kThumb_m);
  add_limb(world, p(-0.010, -0.028, half + kThumb_m), p(-0.045, -0.014, half + kThumb_m), kThumb_m);
  for (int i = 0; i < 4; ++i) {
    const double along = -0.030 + 0.020 * i, reach = i == 3 ? -0.045 : -0.060;
    add_limb(world, p(0.030, along, -half - 0.012), p(-0.010, along, -half - kFinger_m), kFinger_m);
    add_limb(world, p(-0.010, along, -half - kFinger_m), p(reach, along, -half - kFinger_m), kFinger_m);
  }
}

void add_wrapping_hand(World& world, const Grip& g) {
  const double radius = 0.5 * g.thickness;
  const Vec3 axis = g.at - radius * g.out;
  // a finger as three straight bones whose middles touch the bar
  const auto finger = [&](double from, double to, double along_from, double along_to, double thickness) {
    constexpr int kBones = 3;
    const double bone = (to - from) / kBones, apart = (radius + thickness) / std::cos(0.5 * bone);
    const auto joint_at = [&](int k) {
      const double angle = from + bone * k, along = along_from + (along_to - along_from) * k / kBones;
      return Vec3(axis + along * g.along + apart * (std::cos(angle) * g.out + std::sin(angle) * g.across));
    };
    for (int k = 0; k < kBones; ++k) add_limb(world, joint_at(k), joint_at(k + 1), thickness);
  };
  add_block(world, g.at + 0.014 * g.out, g.out, g.along, {0.028, 0.082, 0.070});
  // fingers are about 8 cm long, however thick the bar
  const double reach = std::min(0.085 / (radius + kFinger_m), 2.6);
  for (int i = 0; i < 4; ++i) finger(0.35, 0.35 + reach, -0.030 + 0.020 * i, -0.030 + 0.020 * i, kFinger_m);
  finger(-0.35, -0.35 - std::min(0.05 / (radius + kThumb_m), 1.4), -0.03, -0.02, kThumb_m);
}

// palm on the face below the edge; `across` is the outward normal of the face that the fingers lie on
void add_hooking_hand(World& world, const Grip& g) {
  const auto p = [&](double out, double along, double across) {
    return Vec3(g.at + out * g.out + along * g.along + across * g.across);
  };
  add_block(world, p(0.013, 0, -0.045), g.out, g.along, {0.026, 0.082, 0.090});
  for (int i = 0; i < 4; ++i) {
    const double along = -0.030 + 0.020 * i, reach = i == 3 ? -0.040 : -0.055;
    add_limb(world, p(0.010, along, -0.010), p(0.006, along, kFinger_m), kFinger_m);
    add_limb(world, p(0.006, along, kFinger_m), p(reach, along, kFinger_m), kFinger_m);
  }
  add_limb(world, p(kThumb_m, -0.045, -0.06), p(kThumb_m, -0.075, -0.02), kThumb_m);
}

// `across` points from the fingers towards the arm
void add_flat_hand(World& world, const Grip& g) {
  const auto p = [&](double out, double along, double across) {
    return Vec3(g.at + out * g.out + along * g.along + across * g.across);
  };
  add_block(world, p(0.013, 0, 0), g.out, g.along, {0.026, 0.082, 0.090});
  for (int i = 0; i < 4; ++i) {
    const double along = -0.033 + 0.022 * i, reach = i == 3 ? -0.095 : -0.115;
    add_limb(world, p(kFinger_m, along, -0.040), p(kFinger_m, 1.15 * along, reach), kFinger_m);
  }
  add_limb(world, p(kThumb_m, -0.040, 0.010), p(kThumb_m, -0.080, -0.035), kThumb_m);
}

}  // namespace

Vec3 Grip::wrist() const {
  switch (kind) {
    case Kind::Pinch:
      return at + 0.095 * out;
    case Kind::Wrap:
      return at + 0.030 * out - 0.075 * across;
    case Kind::Hook:
      return at + 0.045 * out - 0.105 * across;
    case Kind::Flat:
      return at + 0.050 * out + 0.085 * across;
  }
  return at;
}

Grip find_grip(const World& world, const Vec3& contact, const Vec3& from) {
  const Shape* nearest = nullptr;
  double smallest = 0.0;
  for (const Shape& shape : world.shapes) {
    if (shape.label != Label::Target) continue;
    const double d = std::abs(distance(shape, contact));
    if (!nearest || d < smallest - 1e-9) nearest = &shape, smallest = d;
  }
  if (nearest && nearest->kind == Shape::Kind::Box) return grip_on_box(*nearest, contact, from);
  if (nearest && nearest->kind == Shape::Kind::Cylinder) {
    return with_thumb_away(grip_on_round(*nearest, contact), from - contact);
  }
  Grip g;
  g.at = contact;
  g.out = (from - contact).normalized();
  std::tie(g.along, g.across) = hal::tangents(g.out);
  return g;
}

void add_hand(World& world, const Grip& grip) {
  switch (grip.kind) {
    case Grip::Kind::Pinch:
      return add_pinching_hand(world, grip);
    case Grip::Kind::Wrap:
      return add_wrapping_hand(world, grip);
    case Grip::Kind::Hook:
      return add_hooking_hand(world, grip);
    case Grip::Kind::Flat:
      return add_flat_hand(world, grip);
  }
}

void add_person(World& world, const Posture& p) {
  const Vec3 middle = 0.5 * (p.right_shoulder + p.left_shoulder);
  const Vec3 right = (p.right_shoulder - p.left_shoulder).normalized();
  // who stoops moves the hips back and down; the trunk is half a metre long
  const double stoop = std::clamp((1.42 - middle.z()) / 0.8, 0.0, 1.0);
  Vec3 trunk = (Vec3::UnitZ() + 0.9 * stoop * p.facing).normalized();
  Vec3 hip = p.hip.value_or(middle - 0.50 * trunk);
  hip.z() = std::max(hip.z(), 0.30);
  if (p.hip) trunk = (middle - hip).normalized();

  add_limb(world, hip, middle - 0.13 * trunk, 0.125, BodyPart::Trunk);
  add_limb(world, p.right_shoulder - 0.05 * right, p.left_shoulder + 0.05 * right, 0.06, BodyPart::Shoulders);
  add_limb(world, middle, middle + 0.14 * trunk, 0.05, BodyPart::Neck);
  add(world, sphere(middle + 0.22 * trunk + 0.05 * p.facing, 0.105, Label::Partner), BodyPart::Head);
  add_leg(world, hip + 0.10 * right, p.right_foot, p, false);
  add_leg(world, hip - 0.10 * right, p.left_foot, p, true);

  const auto hanging = [&](const Vec3& shoulder, double side) {
    return Vec3(shoulder - 0.52 * Vec3::UnitZ() + side * 0.05 * right + 0.05 * p.facing);
  };
  add_arm(world, p.right_shoulder, p.right_wrist.value_or(hanging(p.right_shoulder, 1.0)), right, false);
  add_arm(world, p.left_shoulder, p.left_wrist.value_or(hanging(p.left_shoulder, -1.0)), -right, true);
  // a hanging hand
  const auto hang = [&](const Vec3& wrist, bool left) {
    add_limb(world, wrist, wrist - 0.14 * Vec3::UnitZ(), 0.03, BodyPart::Hand, left);
  };
  if (!p.right_wrist) hang(hanging(p.right_shoulder, 1.0), false);
  if (!p.left_wrist) hang(hanging(p.left_shoulder, -1.0), true);
  if (p.right_wrist && p.right_tip) add_reaching_hand(world, *p.right_wrist, *p.right_tip);
}

}  // namespace colift::sim_hal
