#include "sim_hal/synthetic/stances.hpp"

#include <algorithm>

#include "hal/types/units.hpp"

namespace colift::sim_hal {
namespace {

using Turn = Eigen::Quaterniond;

Turn about(const Vec3& axis, double deg) {
  return Turn(Eigen::AngleAxisd(hal::deg_to_rad(deg), axis));
}

// Angles in degrees. In the frame of the pelvis x is forward, y to the left, z along the spine.
struct Leg {
  double hip_flexion = 0.0, hip_abduction = 4.0, knee_flexion = 5.0;
};
struct Arm {
  double flexion = 5.0, abduction = 8.0, elbow_flexion = 15.0;
};
struct Angles {
  double pelvis_pitch = 0.0, pelvis_roll = 0.0;  // forward, to the right
  double bend = 0.0, nod = 0.0;                  // of the spine and of the neck, forward
  std::array<Leg, 2> legs;                       // left, right
  std::array<Arm, 2> arms;
};

Arm any_arm(Draws& d) {
  return {d.between(-20, 100), d.between(5, 80), d.between(5, 120)};
}
Arm hanging_arm(Draws& d) {
  return {d.between(-15, 35), d.between(4, 18), d.between(5, 50)};
}
// of a trunk that is bent forward: to the floor, to a knee, towards an object
Arm reaching_arm(Draws& d) {
  return {d.between(40, 110), d.between(0, 25), d.between(5, 60)};
}

Angles draw(Stance stance, Draws& d) {
  Angles a;
  a.nod = d.between(-10, 30);
  for (Arm& arm : a.arms) arm = d.chance(0.6) ? hanging_arm(d) : any_arm(d);
  switch (stance) {
    case Stance::Standing:
      a.bend = d.between(-3, 12);
      for (Leg& leg : a.legs) leg = {d.between(-8, 12), d.between(2, 12), d.between(0, 12)};
      break;
    case Stance::Stooping:
      a.bend = d.between(35, 95);
      for (Leg& leg : a.legs) leg = {d.between(0, 25), d.between(2, 15), d.between(0, 30)};
      for (Arm& arm : a.arms) arm = reaching_arm(d);
      break;
    case Stance::SittingLow: {
      a.bend = d.between(-15, 30);
      const double knees = d.between(5, 110), apart = d.between(3, 35);
      for (Leg& leg : a.legs) leg = {88 + 0.45 * knees + d.between(-4, 4), apart, knees + d.between(-5, 5)};
      break;
    }
    case Stance::Crouching:
      a.bend = d.between(15, 55);
      for (Leg& leg : a.legs) leg = {d.between(85, 115), d.between(5, 30), d.between(115, 140)};
      for (Arm& arm : a.arms) arm = reaching_arm(d);
      break;
    case Stance::Kneeling: {
      const double back = d.between(0, 50);  // down towards the heels
      a.bend = d.between(-5, 60);
      for (Leg& leg : a.legs) leg = {back, d.between(2, 15), 90 + back};
      if (a.bend > 25)
        for (Arm& arm : a.arms) arm = reaching_arm(d);
      break;
    }
    case Stance::OnOneKnee: {
      const int down = d.below(2);
      a.bend = d.between(-5, 50);
      a.legs[static_cast<std::size_t>(down)] = {d.between(-5, 10), 4, d.between(90, 100)};
      a.legs[static_cast<std::size_t>(1 - down)] = {d.between(85, 95), 6, d.between(85, 95)};
      break;
    }
    case Stance::OnAllFours:
      a.pelvis_pitch = d.between(75, 95);
      for (Leg& leg : a.legs) leg = {d.between(80, 100), d.between(2, 12), d.between(85, 100)};
      for (Arm& arm : a.arms) arm = {d.between(75, 95), d.between(0, 12), d.between(0, 15)};
      a.nod = d.between(-40, 20);
      break;
    case Stance::LyingOnBack: {
      a.pelvis_pitch = -90;
      const double knees = d.chance(0.5) ? d.between(0, 15) : d.between(30, 110);
      for (Leg& leg : a.legs) leg = {0.5 * knees, d.between(2, 20), knees};
      for (Arm& arm : a.arms) arm = {d.between(-4, 10), d.between(5, 165), d.between(0, 110)};
      break;
    }
    case Stance::LyingFaceDown:
      a.pelvis_pitch = 90;
      a.nod = d.between(-10, 5);
      for (Leg& leg : a.legs) leg = {d.between(0, 3), d.between(2, 25), d.between(0, 12)};
      for (Arm& arm : a.arms) arm = {d.between(0, 12), d.between(5, 165), d.between(0, 20)};
      break;
    case Stance::LyingOnSide: {
      a.pelvis_roll = (d.chance(0.5) ? 1 : -1) * d.between(75, 100);
      const double curled = d.between(5, 100);
      a.bend = 0.4 * curled;
      for (Leg& leg : a.legs) leg = {curled + d.between(-10, 10), 0.0, curled + d.between(0, 20)};
      for (Arm& arm : a.arms) arm = {d.between(10, 110), d.between(-5, 10), d.between(5, 120)};
      break;
    }
  }
  return a;
}

class Body {
 public:
  Body(const Angles& angles, double height_m) : a_(angles), size_(height_m / 1.75) {}

  std::vector<Shape> make() {
    const Turn pelvis = about(Vec3::UnitX(), a_.pelvis_roll) * about(Vec3::UnitY(), a_.pelvis_pitch);
    const Turn chest = pelvis * about(Vec3::UnitY(), a_.bend);
    const Vec3 waist = pelvis * (0.10 * size_ * Vec3::UnitZ());
    const auto on_chest = [&](double x, double y, double z) {
      return Vec3(waist + chest * (size_ * Vec3(x, y, z)));
    };
    limb(pelvis * (size_ * Vec3(0, 0.07, 0)), pelvis * (size_ * Vec3(0, -0.07, 0)), 0.105, BodyPart::Trunk);
    for (const double side : {1.0, -1.0})  // a chest is a third wider than it is deep
      limb(on_chest(0, 0.06 * side, -0.02), on_chest(0, 0.065 * side, 0.29), 0.105, BodyPart::Trunk,
           side > 0);
    limb(on_chest(0, 0.14, 0.36), on_chest(0, -0.14, 0.36), 0.065, BodyPart::Shoulders);
    const Turn neck = chest * about(Vec3::UnitY(), a_.nod);
    const Vec3 nape = on_chest(0, 0, 0.40);
    limb(nape, nape + neck * (size_ * Vec3(0.01, 0, 0.10)), 0.055, BodyPart::Neck);
    limb(nape + neck * (size_ * Vec3(0.03, 0, 0.16)), nape + neck * (size_ * Vec3(0.02, 0, 0.21)), 0.095,
         BodyPart::Head);
    for (std::size_t k = 0; k < 2; ++k) {
      leg(pelvis, a_.legs[k], k == 0);
      arm(chest, on_chest(0, k == 0 ? 0.185 : -0.185, 0.36), a_.arms[k], k == 0);
    }
    return std::move(shapes_);
  }

 private:
  void limb(const Vec3& from, const Vec3& to, double radius, BodyPart part, bool left = false) {
    Shape s = capsule(from, to, size_ * radius, Label::Partner);
    s.part = part;
    s.left = left;
    shapes_.push_back(s);
  }

  void leg(const Turn& pelvis, const Leg& l, bool left) {
    const double side = left ? 1.0 : -1.0;
    const Turn thigh =
        pelvis * about(Vec3::UnitX(), side * l.hip_abduction) * about(Vec3::UnitY(), -l.hip_flexion);
    const Turn shin = thigh * about(Vec3::UnitY(), l.knee_flexion);
    const Vec3 hip = pelvis * (size_ * Vec3(0, side * 0.09, -0.02));
    const Vec3 knee = hip + thigh * (size_ * Vec3(0, 0, -0.43)),
               ankle = knee + shin * (size_ * Vec3(0, 0, -0.42));
    limb(hip, knee, 0.073, BodyPart::Thigh, left);
    limb(knee, ankle, 0.05, BodyPart::LowerLeg, left);
    limb(ankle + shin * (size_ * Vec3(-0.04, 0, -0.02)), ankle + shin * (size_ * Vec3(0.16, 0, -0.03)), 0.04,
         BodyPart::Foot, left);
  }

  void arm(const Turn& chest, const Vec3& shoulder, const Arm& m, bool left) {
    const double side = left ? 1.0 : -1.0;
    const Turn upper = chest * about(Vec3::UnitX(), side * m.abduction) * about(Vec3::UnitY(), -m.flexion);
    const Turn fore = upper * about(Vec3::UnitY(), -m.elbow_flexion);
    const Vec3 elbow = shoulder + upper * (size_ * Vec3(0, 0, -0.30)),
               wrist = elbow + fore * (size_ * Vec3(0, 0, -0.25));
    limb(shoulder, elbow, 0.046, BodyPart::UpperArm, left);
    limb(elbow, wrist, 0.035, BodyPart::LowerArm, left);
    limb(wrist, wrist + fore * (size_ * Vec3(0, 0, -0.13)), 0.03, BodyPart::Hand, left);
  }

  Angles a_;
  double size_;
  std::vector<Shape> shapes_;
};

}  // namespace

std::string_view word(Stance stance) {
  switch (stance) {
    case Stance::Standing:
      return "standing";
    case Stance::Stooping:
      return "stooping";
    case Stance::SittingLow:
      return "sitting on the floor";
    case Stance::Crouching:
      return "crouching";
    case Stance::Kneeling:
      return "kneeling";
    case Stance::OnOneKnee:
      return "on one knee";
    case Stance::OnAllFours:
      return "on all fours";
    case Stance::LyingOnBack:
      return "lying on the back";
    case Stance::LyingFaceDown:
      return "lying face down";
    case Stance::LyingOnSide:
      return "lying on the side";
  }
  return "?";
}

std::vector<Shape> person_in(Stance stance, Draws& draws, const Vec3& at, double yaw) {
  const double height_m = draws.between(1.5, 1.95), cloth = draws.between(0.25, 0.7);
  std::vector<Shape> shapes = Body(draw(stance, draws), height_m).make();
  double lowest = 0.0;
  for (const Shape& s : shapes)
    for (const double end : {-0.5, 0.5}) {
      const Vec3 tip = s.X_WS * Vec3(0, 0, end * s.size[1]);
      lowest = std::min(lowest, tip.z() - s.size[0]);
    }
  Pose place = Pose::Identity();
  place.linear() = Eigen::AngleAxisd(yaw, Vec3::UnitZ()).toRotationMatrix();
  place.translation() = Vec3(at.x(), at.y(), -lowest);
  for (Shape& s : shapes) {
    s.X_WS = place * s.X_WS;
    s.reflectivity = cloth;
  }
  return shapes;
}

}  // namespace colift::sim_hal
