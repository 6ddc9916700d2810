#include "sim_hal/synthetic/scene_objects.hpp"

#include <array>
#include <cmath>
#include <numbers>

#include "hal/types/units.hpp"

namespace colift::sim_hal {
namespace {

constexpr Label kTarget = Label::Target;

Vec3 half_size(const Shape& s) {
  switch (s.kind) {
    case Shape::Kind::Cylinder:
      return {s.size[0], s.size[0], 0.5 * s.size[1]};
    case Shape::Kind::Capsule:
      return {s.size[0], s.size[0], 0.5 * s.size[1] + s.size[0]};
    case Shape::Kind::Sphere:
      return Vec3::Constant(s.size[0]);
    default:
      return 0.5 * s.size;
  }
}

double volume(const Shape& s) {
  if (s.kind == Shape::Kind::Cylinder) return std::numbers::pi * s.size[0] * s.size[0] * s.size[1];
  return s.size.prod();
}

class Builder {
 public:
  explicit Builder(ObjectModel& model) : model_(model) {}

  void part(const Shape& s) { model_.parts.push_back(s); }
  void plain_box(const Vec3& center, const Vec3& size) { part(box(center, size, 0.0, kTarget)); }

  /// One face of an axis-aligned box: `axis` 0 to 2, outwards along +1 or -1.
  void face(const Vec3& center, const Vec3& size, int axis, double side) {
    const Vec3 n = side * Vec3::Unit(axis);
    const int a = (axis + 1) % 3, b = (axis + 2) % 3;
    TrueFace f;
    f.center = center + 0.5 * size[axis] * n;
    f.normal = n;
    f.u = Vec3::Unit(a);
    f.v = n.cross(f.u);
    f.width = size[a];
    f.height = size[b];
    model_.faces.push_back(f);
  }
  void all_faces(const Vec3& center, const Vec3& size) {
    for (const int axis : {2, 0, 1})
      for (const double side : {1.0, -1.0}) face(center, size, axis, side);
  }
  void side_faces(const Vec3& center, const Vec3& size) {
    for (const int axis : {0, 1})
      for (const double side : {1.0, -1.0}) face(center, size, axis, side);
  }

  /// Points every 8 cm or so along a line, clear of its ends.
  void graspable_along(const Vec3& from, const Vec3& to) {
    constexpr double kFromEnd_m = 0.07, kSpacing_m = 0.08;
    const double length = (to - from).norm();
    if (length < 2 * kFromEnd_m) {
      model_.graspable.push_back(0.5 * (from + to));
      return;
    }
    const Vec3 along = (to - from) / length;
    const int steps = std::max(1, static_cast<int>((length - 2 * kFromEnd_m) / kSpacing_m));
    for (int i = 0; i <= steps; ++i)
      model_.graspable.push_back(from + along * (kFromEnd_m + (length - 2 * kFromEnd_m) * i / steps));
  }

  void rim(double half_x, double half_y, double z) {
    const std::array<Vec3, 4> c{Vec3(half_x, half_y, z), Vec3(-half_x, half_y, z), Vec3(-half_x, -half_y, z),
                                Vec3(half_x, -half_y, z)};
    for (std::size_t i = 0; i < 4; ++i) graspable_along(c[i], c[(i + 1) % 4]);
  }

 private:
  ObjectModel& model_;
};

struct Legs {
  double half_x, half_y, height, thickness;
  bool round;
};

void add_legs(ObjectModel& model, const Legs& legs) {
  Builder b(model);
  for (const double sx : {1.0, -1.0})
    for (const double sy : {1.0, -1.0}) {
      const Vec3 center(sx * legs.half_x, sy * legs.half_y, 0.5 * legs.height);
      const Vec3 size(legs.thickness, legs.thickness, legs.height);
      if (legs.round) {
        b.part(cylinder(center, Vec3::UnitZ(), 0.5 * legs.thickness, legs.height, kTarget));
        model.cylinders.push_back({center, Vec3::UnitZ(), 0.5 * legs.thickness, legs.height});
      } else {
        b.plain_box(center, size);
        b.side_faces(center, size);
      }
    }
}

ObjectModel table(Draws& d) {
  ObjectModel m;
  const Vec3 top(d.between(0.6, 1.2), d.between(0.4, 0.8), d.between(0.02, 0.03));
  const double height = d.between(0.4, 0.75);
  const double leg = d.between(0.03, 0.05), inset = d.between(0.0, 0.05);
  const bool round = d.chance(0.25);
  const Vec3 center(0, 0, height - 0.5 * top.z());
  Builder b(m);
  b.plain_box(center, top);
  b.all_faces(center, top);
  b.rim(0.5 * top.x(), 0.5 * top.y(), center.z());
  add_legs(m, {0.5 * (top.x() - leg) - inset, 0.5 * (top.y() - leg) - inset, height - top.z(), leg, round});
  m.name = round ? "table with round legs" : "table";
  return m;
}

ObjectModel closed_box(Draws& d) {
  ObjectModel m;
  const Vec3 size(d.between(0.35, 0.8), d.between(0.3, 0.6), d.between(0.3, 0.6));
  const Vec3 center(0, 0, 0.5 * size.z());
  Builder b(m);
  b.plain_box(center, size);
  b.all_faces(center, size);
  b.rim(0.5 * size.x(), 0.5 * size.y(), size.z());
  m.name = "closed box";
  return m;
}

ObjectModel open_box(Draws& d) {
  ObjectModel m;
  const Vec3 size(d.between(0.4, 0.8), d.between(0.3, 0.6), d.between(0.25, 0.5));
  const double wall = d.between(0.01, 0.02);
  const double x = 0.5 * (size.x() - wall), y = 0.5 * (size.y() - wall), z = 0.5 * size.z();
  const Vec3 long_wall(size.x(), wall, size.z()), short_wall(wall, size.y() - 2 * wall, size.z());
  const Vec3 bottom(size.x() - 2 * wall, size.y() - 2 * wall, wall);
  Builder b(m);
  for (const double s : {1.0, -1.0}) {
    b.plain_box({0, s * y, z}, long_wall);
    b.plain_box({s * x, 0, z}, short_wall);
  }
  b.plain_box({0, 0, 0.5 * wall}, bottom);
  b.side_faces({0, 0, z}, size);
  for (const double s : {1.0, -1.0}) {
    const Vec3 inner_long(size.x() - 2 * wall, wall, size.z() - wall);
    const Vec3 inner_short(wall, size.y() - 2 * wall, size.z() - wall);
    b.face({0, s * y, z + 0.5 * wall}, inner_long, 1, -s);
    b.face({s * x, 0, z + 0.5 * wall}, inner_short, 0, -s);
    b.face({0, s * y, z}, long_wall, 2, 1.0);
    b.face({s * x, 0, z}, short_wall, 2, 1.0);
  }
  b.face({0, 0, 0.5 * wall}, bottom, 2, 1.0);
  b.face({0, 0, 0.5 * wall}, {size.x(), size.y(), wall}, 2, -1.0);
  b.rim(x, y, size.z());
  m.name = "open box";
  return m;
}

ObjectModel pipe(Draws& d) {
  ObjectModel m;
  const double radius = d.between(0.025, 0.07), length = d.between(0.8, 1.5);
  const bool on_blocks = d.chance(0.25);
  const double block = on_blocks ? d.between(0.10, 0.25) : 0.0;
  const Vec3 center(0, 0, block + radius);
  m.parts.push_back(cylinder(center, Vec3::UnitX(), radius, length, kTarget));
  m.cylinders.push_back({center, Vec3::UnitX(), radius, length});
  if (on_blocks)
    for (const double side : {1.0, -1.0}) {
      const Vec3 size(d.between(0.06, 0.12), d.between(0.14, 0.25), block);
      m.supports.push_back(
          box({side * length * d.between(0.22, 0.36), 0, 0.5 * block}, size, 0.0, Label::Clutter));
    }
  Builder b(m);
  for (const double angle_deg : {0.0, 45.0, -45.0}) {
    const double a = hal::deg_to_rad(angle_deg);
    const Vec3 out(0, std::sin(a), std::cos(a));
    b.graspable_along(center + radius * out - 0.5 * length * Vec3::UnitX(),
                      center + radius * out + 0.5 * length * Vec3::UnitX());
  }
  m.name = on_blocks ? "pipe on blocks" : "pipe";
  return m;
}

ObjectModel chair(Draws& d) {
  ObjectModel m;
  const Vec3 seat(d.between(0.38, 0.50), d.between(0.40, 0.50), d.between(0.02, 0.04));
  const double height = d.between(0.42, 0.48), total = d.between(0.80, 0.98);
  const double leg = d.between(0.03, 0.04);
  const Vec3 center(0, 0, height - 0.5 * seat.z());
  Builder b(m);
  b.plain_box(center, seat);
  b.all_faces(center, seat);
  add_legs(m, {0.5 * (seat.x() - leg), 0.5 * (seat.y() - leg), height - seat.z(), leg, false});

  // the back rest stands on the rear edge of the seat, rear is -x
  const double back_x = -0.5 * (seat.x() - leg), back_height = total - height;
  const bool plate = d.chance(0.5);
  if (plate) {
    const Vec3 size(d.between(0.018, 0.03), seat.y(), back_height);
    const Vec3 c(-0.5 * (seat.x() - size.x()), 0, height + 0.5 * back_height);
    b.plain_box(c, size);
    for (const int axis : {0, 1})
      for (const double side : {1.0, -1.0}) b.face(c, size, axis, side);
    b.face(c, size, 2, 1.0);
    b.graspable_along({c.x(), -0.5 * seat.y(), total}, {c.x(), 0.5 * seat.y(), total});
  } else {
    for (const double s : {1.0, -1.0}) {
      const Vec3 c(back_x, s * 0.5 * (seat.y() - leg), height + 0.5 * back_height),
          size(leg, leg, back_height);
      b.plain_box(c, size);
      b.side_faces(c, size);
    }
    const int slats = 2 + d.below(3);
    const double slat_height = d.between(0.04, 0.06), thickness = d.between(0.015, 0.022);
    const double lowest = height + 0.12, highest = total - 0.5 * slat_height;
    const Vec3 size(thickness, seat.y() - 2 * leg, slat_height);
    for (int i = 0; i < slats; ++i) {
      const Vec3 c(back_x, 0, lowest + (highest - lowest) * i / (slats - 1));
      b.plain_box(c, size);
      b.face(c, size, 0, 1.0);
      b.face(c, size, 0, -1.0);
      b.face(c, size, 2, 1.0);
    }
    b.graspable_along({back_x, -0.5 * size.y(), total}, {back_x, 0.5 * size.y(), total});
  }
  const double rim_x = 0.5 * seat.x(), rim_y = 0.5 * seat.y();
  b.graspable_along({rim_x, -rim_y, center.z()}, {rim_x, rim_y, center.z()});
  b.graspable_along({rim_x, rim_y, center.z()}, {-rim_x, rim_y, center.z()});
  b.graspable_along({rim_x, -rim_y, center.z()}, {-rim_x, -rim_y, center.z()});
  m.name = plate ? "chair with a plate as back" : "chair with slats";
  return m;
}

}  // namespace

std::vector<Vec3> corners(const Shape& shape) {
  const Vec3 half = half_size(shape);
  std::vector<Vec3> result;
  for (int i = 0; i < 8; ++i) {
    const Vec3 sign(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1);
    result.push_back(shape.X_WS * Vec3(half.cwiseProduct(sign)));
  }
  return result;
}

Vec3 ObjectModel::cog() const {
  Vec3 moment = Vec3::Zero();
  double total = 0.0;
  for (const Shape& part : parts) {
    moment += volume(part) * part.X_WS.translation();
    total += volume(part);
  }
  return moment / total;
}

hal::Aabb ObjectModel::bounds() const {
  hal::Aabb bounds;
  for (const auto* list : {&parts, &supports})
    for (const Shape& shape : *list)
      for (const Vec3& p : corners(shape)) bounds.extend(p);
  return bounds;
}

ObjectModel make_object(ObjectKind kind, Draws& draws) {
  switch (kind) {
    case ObjectKind::Table:
      return table(draws);
    case ObjectKind::Box:
      return closed_box(draws);
    case ObjectKind::OpenBox:
      return open_box(draws);
    case ObjectKind::Pipe:
      return pipe(draws);
    case ObjectKind::Chair:
      return chair(draws);
  }
  return {};
}

}  // namespace colift::sim_hal
