#include "sim_hal/synthetic/rooms.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "hal/types/units.hpp"
#include "sim_hal/synthetic/hash_random.hpp"
#include "sim_hal/synthetic/person.hpp"
#include "sim_hal/synthetic/scene_objects.hpp"

namespace colift::sim_hal {
namespace {

constexpr double kWallThick_m = 0.1, kRoomHeight_m = 2.7;

// Places are drawn in the room's own frame R: the camera above the origin looks along Rx; the back wall
// crosses it.
class RoomMaker {
 public:
  RoomMaker(std::uint64_t seed, bool occupied) : draws_(seed, 9100), occupied_(occupied) {}

  RandomRoom make(std::uint64_t seed) {
    constexpr DepthSensor kSensors[] = {DepthSensor::Kinect, DepthSensor::Xtion, DepthSensor::ActiveStereo,
                                        DepthSensor::TimeOfFlight};
    room_.sensor = kSensors[draws_.below(4)];
    room_.intrinsics = intrinsics_of(room_.sensor);
    add(half_space(Vec3::Zero(), Vec3::UnitZ(), Label::Ground), draws_.between(0.3, 0.8));
    back_ = draws_.between(2.2, 4.5);
    walls();
    furniture();
    if (draws_.chance(0.8)) object();
    if (room_.has_object) small_things();
    if (occupied_)
      somebody();
    else if (draws_.chance(0.35))
      person();
    camera();
    room_.name = fmt::format("room {}: {}{}", seed, name_of(room_.sensor), words_);
    return std::move(room_);
  }

 private:
  void add(Shape s, double reflectivity) {
    s.reflectivity = reflectivity;
    room_.world.shapes.push_back(s);
  }
  void say(const std::string& what) { words_ += ", " + what; }

  // a box that stands on the floor; x, y: its middle
  void block(double x, double y, double from_z, const Vec3& size, double yaw, Label label) {
    add(box({x, y, from_z + 0.5 * size.z()}, size, yaw, label), draws_.between(0.25, 0.9));
  }

  void walls() {
    add(box({back_ + 0.5 * kWallThick_m, 0, 0.5 * kRoomHeight_m}, {kWallThick_m, 9, kRoomHeight_m}, 0,
            Label::Wall),
        draws_.between(0.4, 0.9));
    for (const double side : {-1.0, 1.0}) {
      if (!draws_.chance(0.45)) continue;
      const double away = draws_.between(1.1, 2.4);
      add(box({0.5 * back_, side * (away + 0.5 * kWallThick_m), 0.5 * kRoomHeight_m},
              {back_ + 3, kWallThick_m, kRoomHeight_m}, 0, Label::Wall),
          draws_.between(0.4, 0.9));
      say("side wall");
    }
    if (draws_.chance(0.4)) {  // a door with its frame, a little before the wall
      const double y = draws_.between(-1.3, 1.3), w = draws_.between(0.8, 1.0),
                   out = draws_.between(0.01, 0.06);
      block(back_ - 0.5 * out, y, 0.0, {out, w, 2.05}, 0, Label::Wall);
      say("door");
    }
    if (draws_.chance(0.3)) {  // glass gives no depth
      const double y = draws_.between(-1.3, 1.3);
      add(box({back_ - 0.005, y, 1.6}, {0.01, draws_.between(0.8, 1.6), 1.2}, 0, Label::Wall), 0.0);
      say("window");
    }
  }

  void furniture() {
    const int pieces = draws_.below(4);
    double y = draws_.between(-1.6, -0.6);
    for (int k = 0; k < pieces; ++k) {
      const double w = draws_.between(0.5, 1.3);
      switch (draws_.below(4)) {
        case 0: {
          const double depth = draws_.between(0.35, 0.6);
          block(back_ - 0.5 * depth, y + 0.5 * w, 0.0, {depth, w, draws_.between(0.8, 2.1)}, 0,
                Label::Clutter);
          say("cupboard");
          break;
        }
        case 1: {  // a shelf: sides, boards, no back
          const double depth = draws_.between(0.25, 0.4), high = draws_.between(1.0, 2.0);
          for (const double side : {0.0, w})
            block(back_ - 0.5 * depth, y + side, 0.0, {depth, 0.02, high}, 0, Label::Clutter);
          for (double z = 0.1; z < high; z += 0.38)
            block(back_ - 0.5 * depth, y + 0.5 * w, z, {depth, w - 0.02, 0.02}, 0, Label::Clutter);
          say("shelf");
          break;
        }
        case 2: {  // a sofa
          const double wide = w + 0.7;
          block(back_ - 0.55, y + 0.5 * wide, 0.05, {0.75, wide, 0.37}, 0, Label::Clutter);
          block(back_ - 0.18, y + 0.5 * wide, 0.05, {0.2, wide, 0.8}, 0, Label::Clutter);
          for (const double side : {0.0, wide})
            block(back_ - 0.5, y + side, 0.05, {0.85, 0.18, 0.55}, 0, Label::Clutter);
          say("sofa");
          seat_ = Vec3(back_ - 0.55, y + 0.5 * wide, 0.42);
          y += 0.7;
          break;
        }
        default: {  // stairs along the wall
          const double step = 0.18, tread = 0.27;
          for (int s = 0; s < 7; ++s)
            block(back_ - 0.45, y + s * tread, 0.0, {0.9, tread, step * (s + 1)}, 0, Label::Clutter);
          say("stairs");
          y += 7 * tread - w;
          break;
        }
      }
      y += w + draws_.between(0.05, 0.6);
      if (y > 1.6) break;
    }
  }

  void object() {
    constexpr ObjectKind kKinds[] = {ObjectKind::Table, ObjectKind::Box, ObjectKind::OpenBox,
                                     ObjectKind::Pipe, ObjectKind::Chair};
    const ObjectModel model = make_object(kKinds[draws_.below(5)], draws_);
    const hal::Aabb bounds = model.bounds();
    const double radius = 0.5 * bounds.sizes().head<2>().norm();
    const double nearest = std::max(1.0, 0.8 + radius),
                 farthest = std::max(nearest + 0.1, back_ - radius - 0.75);
    Vec3 at(draws_.between(nearest, std::min(3.0, farthest)), draws_.between(-0.5, 0.5), 0);
    at_ = at;
    radius_ = radius;
    Pose X_WT = Pose::Identity();
    X_WT.linear() = Eigen::AngleAxisd(draws_.between(-M_PI, M_PI), Vec3::UnitZ()).toRotationMatrix();
    X_WT.translation() = at - X_WT.linear() * Vec3(bounds.center().x(), bounds.center().y(), 0);
    // one in three stands close before a wall
    if (draws_.chance(0.33) && bounds.sizes().z() > 0.15) {
      const double gap = draws_.between(0.02, 0.3);
      const double behind = at.x() + radius + gap;
      add(box({behind + 0.05, 0, 0.5 * kRoomHeight_m}, {0.1, 9, kRoomHeight_m}, 0, Label::Wall), 0.7);
      back_ = behind;
      // what stood behind it is hidden now, what reached through it is gone
      std::erase_if(room_.world.shapes, [&](const Shape& s) {
        return s.label == Label::Clutter && s.X_WS.translation().x() > at.x() - radius - 1.0;
      });
      seat_.reset();
      say("close wall");
    }
    const double reflectivity = draws_.between(0.3, 0.9);
    for (const auto* list : {&model.parts, &model.supports})
      for (Shape s : *list) {
        s.X_WS = X_WT * s.X_WS;
        s.label = Label::Target;
        add(s, reflectivity);
      }
    room_.has_object = true;
    say(model.name);
  }

  void small_things() {
    const int count = draws_.below(4);
    for (int k = 0; k < count; ++k) {
      const Vec3 p(draws_.between(1.0, back_ - 0.3), draws_.between(-1.2, 1.2), 0);
      if (room_.has_object && (p - at_).norm() < radius_ + 0.35) continue;
      const double x = draws_.between(0.06, 0.22), y = draws_.between(0.06, 0.22),
                   z = draws_.between(0.05, 0.25);
      if (draws_.chance(0.5))
        block(p.x(), p.y(), 0, {x, y, z}, draws_.between(-M_PI, M_PI), Label::Clutter);
      else
        add(cylinder({p.x(), p.y(), 0.5 * z}, Vec3::UnitZ(), 0.4 * x, z, Label::Clutter),
            draws_.between(0.2, 0.9));
      say("thing");
    }
  }

  void person() {
    const double yaw = draws_.between(-M_PI, M_PI);
    Posture p;
    p.facing = {std::cos(yaw), std::sin(yaw), 0};
    Vec3 stand;
    for (int attempt = 0; attempt < 30; ++attempt) {
      stand = {draws_.between(0.9, std::max(1.0, back_ - 0.5)), draws_.between(-1.3, 1.3), 0};
      if (!room_.has_object || (stand - at_).norm() > radius_ + 0.45) break;
    }
    const double size = draws_.between(0.9, 1.08);
    const auto shoulders = [&](const Vec3& middle) {
      const Vec3 right = p.facing.cross(Vec3::UnitZ());
      p.right_shoulder = middle + 0.18 * size * right;
      p.left_shoulder = middle - 0.18 * size * right;
    };
    switch (draws_.below(3)) {
      case 0:
        shoulders(stand + Vec3(0, 0, 1.42 * size));
        say("standing person");
        break;
      case 1: {
        const Vec3 seat = seat_.value_or(stand + Vec3(0, 0, 0.42));
        if (seat_) p.facing = -Vec3::UnitX();
        if (!seat_) block(seat.x(), seat.y(), 0.0, {0.38, 0.38, 0.34}, yaw, Label::Clutter);
        p.hip = seat + Vec3(0, 0, 0.12);
        shoulders(*p.hip + Vec3(0, 0, 0.50 * size) - 0.06 * p.facing);
        const Vec3 right = p.facing.cross(Vec3::UnitZ());
        const Vec3 feet = Vec3(seat.x(), seat.y(), 0.08) + 0.42 * p.facing;
        p.right_foot = feet + 0.12 * right;
        p.left_foot = feet - 0.12 * right;
        say("sitting person");
        break;
      }
      default: {
        p.hip = stand + Vec3(0, 0, 0.32);
        shoulders(*p.hip + Vec3(0, 0, 0.44 * size) + 0.2 * p.facing);
        const Vec3 right = p.facing.cross(Vec3::UnitZ());
        p.right_foot = stand + 0.15 * p.facing + 0.12 * right + Vec3(0, 0, 0.08);
        p.left_foot = stand + 0.15 * p.facing - 0.12 * right + Vec3(0, 0, 0.08);
        say("crouching person");
        break;
      }
    }
    add_person(room_.world, p);
    room_.has_person = true;
  }

  // how far the parts of somebody are from the object and, where that is less than 2 cm, from all else but
  // the floor
  double clearance(const std::vector<Shape>& parts) const {
    constexpr double kAlong[] = {-0.5, -0.25, 0.0, 0.25, 0.5}, kFurniture_m = 0.02;
    double object = 10.0, others = 10.0;
    for (const Shape& part : parts)
      for (const double along : kAlong) {
        const Vec3 p = part.X_WS * Vec3(0, 0, along * part.size[1]);
        for (const Shape& s : room_.world.shapes) {
          if (s.label == Label::Ground) continue;
          double& nearest = s.label == Label::Target ? object : others;
          nearest = std::min(nearest, distance(s, p) - part.size[0]);
        }
      }
    return others < kFurniture_m ? others : object;
  }

  void somebody() {
    constexpr int kPlaces = 200;
    const auto stance = kStances[static_cast<std::size_t>(draws_.below(static_cast<int>(kStances.size())))];
    const double clear = draws_.chance(0.25) ? 0.05 : 0.25;
    const Draws body = draws_;
    std::vector<Shape> parts;
    for (int k = 0; k < kPlaces; ++k) {
      Draws same = body;  // one person, tried in many places
      const Vec3 at(draws_.between(0.9, std::max(1.3, back_ - 0.3)), draws_.between(-1.3, 1.3), 0);
      parts = person_in(stance, same, at, draws_.between(-M_PI, M_PI));
      if (clearance(parts) > clear) break;
      parts.clear();
    }
    if (parts.empty()) return;
    for (const Shape& s : parts) room_.world.shapes.push_back(s);
    somebody_at_ = parts.front().X_WS.translation();
    room_.stance = stance;
    room_.has_person = true;
    say(fmt::format("somebody {}", word(stance)));
  }

  void camera() {
    const double height = draws_.between(0.25, 1.9), aside = draws_.between(-0.3, 0.3);
    const Vec3 eye(draws_.between(-0.3, 0.2), aside, height);
    Vec3 aim(draws_.between(1.4, 2.4), draws_.between(-0.3, 0.3), draws_.between(0.1, 0.5));
    if (room_.has_object)
      aim = at_ + Vec3(draws_.between(-0.2, 0.2), draws_.between(-0.3, 0.3), draws_.between(0.1, 0.4));
    if (somebody_at_ && (!room_.has_object || draws_.chance(0.5)))
      aim = *somebody_at_ + Vec3(0, draws_.between(-0.3, 0.3), draws_.between(-0.2, 0.2));
    room_.X_WC = look_at(eye, aim);
    const double roll = draws_.chance(0.3) ? draws_.between(-12, 12) : draws_.between(-2, 2);
    room_.X_WC.linear() =
        room_.X_WC.linear() * Eigen::AngleAxisd(hal::deg_to_rad(roll), Vec3::UnitZ()).toRotationMatrix();
  }

  Draws draws_;
  bool occupied_;
  RandomRoom room_;
  std::string words_;
  double back_ = 3.0, radius_ = 0.0;
  Vec3 at_ = Vec3::Zero();
  std::optional<Vec3> seat_, somebody_at_;
};

}  // namespace

RandomRoom make_room(std::uint64_t seed) {
  return RoomMaker(seed, false).make(seed);
}

RandomRoom make_occupied_room(std::uint64_t seed) {
  return RoomMaker(seed, true).make(seed);
}

ObjectInView object_in_view(const RandomRoom& room, const Rendering& truth) {
  ObjectInView out;
  World alone;
  for (const Shape& s : room.world.shapes)
    if (s.label == Label::Target) alone.shapes.push_back(s);
  const Rendering whole = cast_rays(alone, room.intrinsics, room.X_WC);
  const int w = room.intrinsics.width, h = room.intrinsics.height;
  std::size_t all = 0;
  for (int v = 0; v < h; ++v) {
    for (int u = 0; u < w; ++u) {
      const auto i = static_cast<std::size_t>(v * w + u);
      all += whole.shape[i] >= 0 ? 1 : 0;
      out.pixels += truth.label[i] == Label::Target ? 1 : 0;
      out.cut |= whole.shape[i] >= 0 && (u < 4 || v < 4 || u >= w - 10 || v >= h - 4);
    }
  }
  if (all > 0) out.hidden_fraction = 1.0 - static_cast<double>(out.pixels) / static_cast<double>(all);
  return out;
}

}  // namespace colift::sim_hal
