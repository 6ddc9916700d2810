#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "sim_hal/synthetic/hash_random.hpp"
#include "sim_hal/synthetic/person.hpp"
#include "sim_hal/synthetic/scene_objects.hpp"
#include "sim_hal/synthetic/scenes.hpp"

namespace colift::sim_hal {
namespace {

constexpr double kShoulders_m = 0.36;  // from joint to joint
constexpr double kHand_m = 0.16;       // what lies nearer to a contact than this is the hand

Vec3 horizontal(const Vec3& v) {
  const Vec3 h(v.x(), v.y(), 0.0);
  return h.norm() > 1e-9 ? Vec3(h.normalized()) : Vec3(Vec3::UnitX());
}

/// First point that a ray from `eye` meets on its way to `point` and 5 cm beyond; infinite where it meets
/// nothing.
Vec3 first_hit(const World& world, const Vec3& eye, const Vec3& point) {
  const Vec3 direction = (point - eye).normalized();
  const double end = (point - eye).norm() + 0.05;
  double t = 0.0;
  for (int step = 0; step < 400 && t < end; ++step) {
    double free = std::numeric_limits<double>::infinity();
    for (const Shape& s : world.shapes) free = std::min(free, distance(s, eye + t * direction));
    if (free < 5e-4) return eye + t * direction;
    t += free;
  }
  return Vec3::Constant(std::numeric_limits<double>::infinity());
}

/// Smallest gap between a person's shape and everything with a label, but for the hands at the contacts.
double gap(const World& world, const Shape& shape, Label label, const std::vector<Vec3>& contacts) {
  double smallest = std::numeric_limits<double>::infinity();
  if (shape.kind == Shape::Kind::Box) return smallest;  // palms, which are where the hands are
  const Vec3 axis = 0.5 * shape.size[1] * shape.X_WS.linear().col(2);
  const double half = shape.kind == Shape::Kind::Capsule ? 1.0 : 0.0;
  for (int i = -6; i <= 6; ++i) {
    const Vec3 p = shape.X_WS.translation() + half * i / 6.0 * axis;
    bool of_hand = false;
    for (const Vec3& contact : contacts) of_hand = of_hand || (p - contact).norm() < kHand_m;
    if (!of_hand) smallest = std::min(smallest, distance(world, label, p) - shape.size[0]);
  }
  return smallest;
}

/// True where no finger and no palm runs into the object by more than soft flesh gives way.
bool hands_fit(const World& with, const std::vector<Vec3>& contacts) {
  constexpr double kGives_m = 0.004;
  for (const Shape& s : with.shapes) {
    if (s.label != Label::Partner || s.kind == Shape::Kind::Sphere) continue;
    const Vec3 p = s.X_WS.translation();
    bool of_hand = false;
    for (const Vec3& contact : contacts) of_hand = of_hand || (p - contact).norm() < kHand_m;
    if (!of_hand) continue;
    if (s.kind == Shape::Kind::Box) {
      for (const Vec3& corner : corners(s))
        if (distance(with, Label::Target, corner) < -kGives_m) return false;
    } else {
      for (int i = -2; i <= 2; ++i) {
        const Vec3 q = p + 0.25 * i * s.size[1] * s.X_WS.linear().col(2);
        if (distance(with, Label::Target, q) < s.size[0] - kGives_m) return false;
      }
    }
  }
  return true;
}

/// True where the persons in `with` keep clear of the object and of walls, and do not run through clutter.
bool keeps_clear(const World& with, const std::vector<Vec3>& contacts, double from_target_m) {
  for (const Shape& s : with.shapes) {
    if (s.label != Label::Partner) continue;
    if (gap(with, s, Label::Target, contacts) < from_target_m) return false;
    if (gap(with, s, Label::Wall, contacts) < 0.0) return false;
    if (gap(with, s, Label::Clutter, contacts) < 0.0) return false;
  }
  return true;
}

bool seen_by(const SyntheticScene& scene, const World& world, const Vec3& point, double within_m) {
  return (first_hit(world, scene.X_WC.translation(), point) - point).norm() < within_m;
}

/// What is visible of a scene with a person in it, in coarse pixels.
struct View {
  std::size_t target_pixels = 0, person_pixels = 0, too_near_pixels = 0;
};

View look(const SyntheticScene& scene, const World& world) {
  constexpr float kTooNear_m = 0.55f;
  const Rendering image = cast_rays(world, coarse(scene.intrinsics), scene.X_WC);
  View view;
  for (std::size_t i = 0; i < image.label.size(); ++i) {
    if (image.label[i] == Label::Target) ++view.target_pixels;
    if (image.label[i] == Label::Partner) ++view.person_pixels;
    if (image.depth_m[i] < kTooNear_m) ++view.too_near_pixels;
  }
  return view;
}

class PartnerMaker {
 public:
  PartnerMaker(const SyntheticScene& scene, std::uint64_t seed, bool two_hands)
      : scene_(scene), draws_(seed, two_hands ? 3000 : 2000), two_hands_(two_hands) {
    for (const Vec3& p : scene.graspable)
      if (seen_by(scene, scene.world, p, 0.04)) seen_.push_back(p);
    if (seen_.empty()) seen_ = scene.graspable;
    for (const Vec3& p : scene.graspable) middle_ += p / static_cast<double>(scene.graspable.size());
    target_pixels_ = look(scene, scene.world).target_pixels;
  }

  /// `found` is false where nothing but a pose that breaks a rule could be drawn.
  PartnerPose make(bool& found) {
    PartnerPose last;
    constexpr int kAttempts = 300;
    for (int attempt = 0; attempt < kAttempts; ++attempt) {
      PartnerPose pose;
      if (!draw(pose)) continue;
      if (!found) last = pose;
      const World with = with_partner(scene_.world, pose);
      std::vector<Vec3> contacts{pose.contact};
      if (pose.second_contact) contacts.push_back(*pose.second_contact);
      if (!hands_fit(with, contacts) || !keeps_clear(with, contacts, 0.01)) continue;
      found = true;
      last = pose;
      // a body in the camera's way is let through only when nothing else was found
      bool seen = true;
      for (const Vec3& c : contacts) seen = seen && seen_by(scene_, with, c, 0.12);
      if (!seen) continue;
      const View view = look(scene_, with);
      if (view.target_pixels * 10 >= target_pixels_ * 6 && view.too_near_pixels * 50 <= view_pixels())
        return pose;
    }
    return last;
  }

 private:
  [[nodiscard]] std::size_t view_pixels() const {
    const hal::CameraIntrinsics k = coarse(scene_.intrinsics);
    return static_cast<std::size_t>(k.width) * static_cast<std::size_t>(k.height);
  }

  bool draw(PartnerPose& pose) {
    pose.contact = seen_[static_cast<std::size_t>(draws_.below(static_cast<int>(seen_.size())))];
    const Vec3 outwards = horizontal(pose.contact - middle_);
    const double turn = draws_.between(-1.3, 1.3);
    const Vec3 away = Eigen::AngleAxisd(turn, Vec3::UnitZ()) * outwards;
    Vec3 stand = pose.contact;
    if (two_hands_) {
      if (!draw_second(pose, away)) return false;
      stand = 0.5 * (pose.contact + *pose.second_contact);
    }
    const double rise = draws_.between(0.28, 0.48);
    const double height = std::clamp(stand.z() + rise, 0.60, 1.42);
    const double reach = draws_.between(0.52, 0.62), dz = height - stand.z();
    const double apart = std::sqrt(std::max(reach * reach - dz * dz, 0.30 * 0.30));
    const Vec3 middle = stand + apart * away + Vec3(0, 0, dz);
    pose.from = middle;
    if (two_hands_) {
      const Vec3 right = (-away).cross(Vec3::UnitZ());
      const double side = right.dot(pose.contact - *pose.second_contact) > 0 ? 1.0 : -1.0;
      pose.from += side * 0.5 * kShoulders_m * right;
    }
    // a wrist bends about 70 degrees, no further
    return horizontal(pose.from - pose.contact).dot(wrist_side(pose.contact, pose.from)) > 0.3;
  }

  // the horizontal direction in which the wrist leaves, or the arm's own where the grip leaves that free
  Vec3 wrist_side(const Vec3& contact, const Vec3& from) const {
    const Grip grip = find_grip(scene_.world, contact, from);
    const bool upwards = std::abs(grip.out.z()) > 0.8;
    return upwards || grip.kind == Grip::Kind::Wrap ? horizontal(from - contact) : horizontal(grip.out);
  }

  bool draw_second(PartnerPose& pose, const Vec3& away) {
    const Vec3 right = (-away).cross(Vec3::UnitZ());
    const Vec3& p = seen_[static_cast<std::size_t>(draws_.below(static_cast<int>(seen_.size())))];
    const Vec3 span = p - pose.contact;
    // both hands before the same body, and a body between them
    if (std::abs(right.dot(span)) < 0.20 || span.norm() > 0.65 || std::abs(away.dot(span)) > 0.30)
      return false;
    pose.second_contact = p;
    return true;
  }

  const SyntheticScene& scene_;
  Draws draws_;
  bool two_hands_;
  std::vector<Vec3> seen_;
  std::size_t target_pixels_ = 0;
  Vec3 middle_ = Vec3::Zero();
};

}  // namespace

World with_partner(const World& world, const PartnerPose& partner) {
  World with = world;
  const Grip grip = find_grip(world, partner.contact, partner.from);
  add_hand(with, grip);

  Posture posture;
  Vec3 aim = partner.contact;
  if (partner.second_contact) aim = 0.5 * (aim + *partner.second_contact);
  posture.facing = horizontal(aim - partner.from);
  Vec3 right = posture.facing.cross(Vec3::UnitZ());
  bool uses_right = true;
  if (partner.second_contact) {
    const Vec3 second = *partner.second_contact;
    // facing is square to the line between the hands, on the side of the object
    const Vec3 between = horizontal(partner.contact - second);
    uses_right = right.dot(between) > 0;
    right = uses_right ? between : Vec3(-between);
    posture.facing = Vec3::UnitZ().cross(right);
    const Grip other = find_grip(world, second, partner.from);
    add_hand(with, other);
    (uses_right ? posture.left_wrist : posture.right_wrist) = other.wrist();
  }
  (uses_right ? posture.right_wrist : posture.left_wrist) = grip.wrist();
  const Vec3 across = kShoulders_m * right;
  posture.right_shoulder = uses_right ? partner.from : Vec3(partner.from + across);
  posture.left_shoulder = uses_right ? Vec3(partner.from - across) : partner.from;
  add_person(with, posture);
  return with;
}

PartnerPose make_partner(const SyntheticScene& scene, std::uint64_t seed, bool two_hands) {
  bool found = false;
  PartnerPose pose = PartnerMaker(scene, seed, two_hands).make(found);
  // small objects leave no room for two hands: then one
  if (two_hands && !found) pose = PartnerMaker(scene, seed, false).make(found);
  return pose;
}

World with_passer_by(const SyntheticScene& scene, std::uint64_t seed, bool in_front) {
  constexpr double kClear_m = 0.12;
  constexpr int kAttempts = 300;
  Draws draws(seed, in_front ? 5000 : 4000);
  Vec3 middle = Vec3::Zero();
  for (const Vec3& p : scene.graspable) middle += p / static_cast<double>(scene.graspable.size());
  const Vec3 eye = scene.X_WC.translation();
  const Vec3 sight = horizontal(middle - eye);
  const double camera_apart = (middle - eye).head<2>().norm();
  const std::size_t target_pixels = look(scene, scene.world).target_pixels;

  World last = scene.world;
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    // the later the attempt, the further aside: a wall may leave no room behind, nor a near camera before
    const double spread = 0.15 + 2.2 * attempt / kAttempts;
    const Vec3 ahead = in_front ? Vec3(-sight) : sight;
    const Vec3 direction = Eigen::AngleAxisd(draws.between(-spread, spread), Vec3::UnitZ()) * ahead;
    const double apart =
        in_front ? draws.between(0.35, std::max(0.5, camera_apart - 0.35)) : draws.between(0.5, 1.9);
    const double height = draws.between(1.30, 1.48),
                 turn = draws.between(-std::numbers::pi, std::numbers::pi);
    const Vec3 stand = Vec3(middle.x(), middle.y(), 0.0) + apart * direction;
    if ((stand - eye).head<2>().norm() < 0.45) continue;

    Posture posture;
    posture.facing = Eigen::AngleAxisd(turn, Vec3::UnitZ()) * Vec3::UnitX();
    const Vec3 right = posture.facing.cross(Vec3::UnitZ());
    posture.right_shoulder = stand + Vec3(0, 0, height) + 0.5 * kShoulders_m * right;
    posture.left_shoulder = posture.right_shoulder - kShoulders_m * right;
    World with = scene.world;
    add_person(with, posture);
    if (!keeps_clear(with, {}, kClear_m)) continue;
    last = std::move(with);
    // before the object: hides some of it and leaves most; who stands closer than the sensor's range is no
    // test
    const View view = look(scene, last);
    if (view.target_pixels * 10 < target_pixels * 5 || view.too_near_pixels > 200) continue;
    if (view.person_pixels < 60) continue;
    if (!in_front || view.target_pixels * 100 < target_pixels * 98) return last;
  }
  return last;
}

}  // namespace colift::sim_hal
