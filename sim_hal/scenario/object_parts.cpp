#include "sim_hal/scenario/object_parts.hpp"

#include <fmt/format.h>

#include <numbers>

#include "hal/types/units.hpp"

namespace colift::sim_hal {
namespace {

constexpr double kTop_m = 0.025, kTableLeg_m = 0.04, kLegInset_m = 0.03;
constexpr double kSeat_m = 0.03, kSeatPart = 0.48, kChairLeg_m = 0.035, kSlat_m = 0.02, kSlatHeight_m = 0.06;

double volume(const Shape& s) {
  if (s.kind == Shape::Kind::Cylinder) return std::numbers::pi * s.size[0] * s.size[0] * s.size[1];
  return s.size.prod();
}

/// About the middle of the piece, in T.
Eigen::Matrix3d inertia(const Shape& s, double mass) {
  Vec3 about;
  if (s.kind == Shape::Kind::Cylinder) {
    const double r2 = s.size[0] * s.size[0], l2 = s.size[1] * s.size[1];
    about = {(3 * r2 + l2) / 12, (3 * r2 + l2) / 12, r2 / 2};
  } else {
    const Vec3 q = s.size.cwiseProduct(s.size);
    about = Vec3(q.y() + q.z(), q.z() + q.x(), q.x() + q.y()) / 12;
  }
  return mass * s.X_WS.linear() * about.asDiagonal() * s.X_WS.linear().transpose();
}

/// Half the extent of a piece along Tx, Ty, Tz.
Vec3 half_extent(const Shape& s) {
  const Eigen::Matrix3d R = s.X_WS.linear();
  if (s.kind == Shape::Kind::Box) return R.cwiseAbs() * (0.5 * s.size);
  const Vec3 axis = R.col(2);
  const Vec3 disc = (Vec3::Ones() - axis.cwiseProduct(axis)).cwiseMax(0.0).cwiseSqrt();
  return s.size[0] * disc + 0.5 * s.size[1] * axis.cwiseAbs();
}

using Pieces = std::vector<Shape>;

void add_box(Pieces& pieces, const Vec3& center, const Vec3& size) {
  pieces.push_back(box(center, size, 0.0, Label::Target));
}

/// Four square legs, their outer faces `inset` inside of the edge.
void add_legs(Pieces& pieces, double length, double width, double height, double leg, double inset) {
  for (const double x : {0.5, -0.5})
    for (const double y : {0.5, -0.5})
      add_box(pieces, {x * (length - leg - 2 * inset), y * (width - leg - 2 * inset), 0.5 * height},
              {leg, leg, height});
}

Pieces table(const Vec3& size) {
  Pieces pieces;
  const double under = size.z() - kTop_m;
  add_box(pieces, {0, 0, size.z() - 0.5 * kTop_m}, {size.x(), size.y(), kTop_m});
  add_legs(pieces, size.x(), size.y(), under, kTableLeg_m, kLegInset_m);
  return pieces;
}

Pieces chair(const Vec3& size) {
  Pieces pieces;
  const double seat = kSeatPart * size.z(), back = size.z() - seat, rear = -0.5 * (size.y() - kChairLeg_m);
  add_box(pieces, {0, 0, seat - 0.5 * kSeat_m}, {size.x(), size.y(), kSeat_m});
  add_legs(pieces, size.x(), size.y(), seat - kSeat_m, kChairLeg_m, 0.0);
  for (const double side : {0.5, -0.5})
    add_box(pieces, {side * (size.x() - kChairLeg_m), rear, seat + 0.5 * back},
            {kChairLeg_m, kChairLeg_m, back});
  const double slat = size.x() - 2 * kChairLeg_m;
  for (const double top : {1.0, 0.6})
    add_box(pieces, {0, rear, seat + top * back - 0.5 * kSlatHeight_m}, {slat, kSlat_m, kSlatHeight_m});
  return pieces;
}

Shape piece(const ScenarioPart& part) {
  Shape s;
  s.kind = part.shape == "cylinder" ? Shape::Kind::Cylinder : Shape::Kind::Box;
  for (std::size_t i = 0; i < part.size.size() && i < 3; ++i)
    s.size[static_cast<Eigen::Index>(i)] = part.size[i];
  s.X_WS.linear() = (Eigen::AngleAxisd(hal::deg_to_rad(part.rpy_deg.z()), Vec3::UnitZ()) *
                     Eigen::AngleAxisd(hal::deg_to_rad(part.rpy_deg.y()), Vec3::UnitY()) *
                     Eigen::AngleAxisd(hal::deg_to_rad(part.rpy_deg.x()), Vec3::UnitX()))
                        .toRotationMatrix();
  s.X_WS.translation() = part.xyz;
  s.label = Label::Target;
  return s;
}

tl::unexpected<hal::Error> refuse(std::string where, std::string reason) {
  return hal::failure(hal::ErrorCode::BadConfig, std::move(where), std::move(reason));
}

hal::Result<Pieces> pieces_of(const ScenarioObject& object) {
  if (object.kind == "bodies") {
    Pieces pieces;
    for (const ScenarioPart& part : object.parts) pieces.push_back(piece(part));
    return pieces;
  }
  const bool round = object.kind == "cylinder";
  if (object.size.size() != (round ? 2U : 3U))
    return refuse("object.size", fmt::format("object.size has {} numbers, but a {} expects {}",
                                             object.size.size(), object.kind, round ? 2 : 3));
  if (round) {
    const double radius = object.size[0];
    return Pieces{cylinder({0, 0, radius}, Vec3::UnitX(), radius, object.size[1], Label::Target)};
  }
  const Vec3 size(object.size[0], object.size[1], object.size[2]);
  if (object.kind == "box") return Pieces{box({0, 0, 0.5 * size.z()}, size, 0.0, Label::Target)};
  if (object.kind == "table") {
    // legs beside each other, and long enough to be legs
    constexpr double kMin_m = 2 * (kTableLeg_m + kLegInset_m), kMinHeight_m = kTop_m + 0.05;
    if (size.x() < kMin_m || size.y() < kMin_m || size.z() < kMinHeight_m)
      return refuse("object.size",
                    fmt::format("object.size is {} x {} x {}, but a table on four legs is at least {:.2f} x "
                                "{:.2f} x {:.3f} m",
                                size.x(), size.y(), size.z(), kMin_m, kMin_m, kMinHeight_m));
    return table(size);
  }
  if (object.kind == "chair") {
    constexpr double kMin_m = 0.15, kMinHeight_m = 0.40;
    if (size.x() < kMin_m || size.y() < kMin_m || size.z() < kMinHeight_m)
      return refuse(
          "object.size",
          fmt::format("object.size is {} x {} x {}, but a chair with legs and back is at least {:.2f} "
                      "x {:.2f} x {:.2f} m",
                      size.x(), size.y(), size.z(), kMin_m, kMin_m, kMinHeight_m));
    return chair(size);
  }
  return refuse(
      "object.kind",
      fmt::format("object.kind expects one of table, box, cylinder, chair, bodies, but found \"{}\"",
                  object.kind));
}

}  // namespace

hal::Result<ObjectParts> object_parts(const ScenarioObject& object) {
  const auto pieces = pieces_of(object);
  if (!pieces) return tl::unexpected(pieces.error());
  if (pieces->empty()) return refuse("object.parts", "object.parts is empty, expected at least one part");

  ObjectParts out;
  double whole = 0.0;
  for (const Shape& s : *pieces) whole += volume(s);
  hal::Aabb bounds;
  Vec3 middle = Vec3::Zero();
  for (std::size_t i = 0; i < pieces->size(); ++i) {
    const Shape& s = (*pieces)[i];
    const double mass = object.kind == "bodies" ? object.parts[i].mass : object.mass * volume(s) / whole;
    out.parts.push_back({s, mass});
    out.mass_kg += mass;
    middle += mass * s.X_WS.translation();
    bounds.extend(Vec3(s.X_WS.translation() - half_extent(s)));
    bounds.extend(Vec3(s.X_WS.translation() + half_extent(s)));
  }
  middle /= out.mass_kg;
  out.cog_T = middle + object.cog_offset;
  if (!bounds.contains(out.cog_T))
    return refuse(
        "object.cog_offset",
        fmt::format("object.cog_offset puts the centre of gravity to [{:.3f}, {:.3f}, {:.3f}], outside of "
                    "the object, which reaches from [{:.3f}, {:.3f}, {:.3f}] to [{:.3f}, {:.3f}, {:.3f}]",
                    out.cog_T.x(), out.cog_T.y(), out.cog_T.z(), bounds.min().x(), bounds.min().y(),
                    bounds.min().z(), bounds.max().x(), bounds.max().y(), bounds.max().z()));
  // the offset moves the mass as a whole: what it does to the spread of the mass nobody can know
  for (const auto& [shape, mass] : out.parts) {
    const Vec3 r = shape.X_WS.translation() - middle;
    out.inertia_T +=
        inertia(shape, mass) + mass * (r.squaredNorm() * Eigen::Matrix3d::Identity() - r * r.transpose());
  }
  return out;
}

Vec3 clutter_xyz(const ScenarioClutter& clutter, double t_s) {
  Vec3 at = clutter.xyz;
  for (std::size_t i = 0; i < clutter.moves.size() && clutter.moves[i].at_s < t_s; ++i) {
    const ClutterMove& move = clutter.moves[i];
    const double until_s = i + 1 < clutter.moves.size() ? std::min(t_s, clutter.moves[i + 1].at_s) : t_s;
    const Vec3 way = move.to - at;
    const double far = way.norm(), gone = move.speed * (until_s - move.at_s);
    at = gone >= far ? move.to : Vec3(at + way * (gone / far));
  }
  return at;
}

std::vector<Shape> clutter_shapes(const Scenario& scenario, double t_s) {
  std::vector<Shape> shapes;
  for (const ScenarioClutter& each : scenario.clutter) {
    ScenarioClutter c = each;
    c.xyz = clutter_xyz(each, t_s);
    if (c.shape == "cylinder") {
      shapes.push_back(
          cylinder(c.xyz + Vec3(0, 0, 0.5 * c.size[1]), Vec3::UnitZ(), c.size[0], c.size[1], Label::Clutter));
    } else {
      const Vec3 size(c.size[0], c.size[1], c.size[2]);
      shapes.push_back(
          box(c.xyz + Vec3(0, 0, 0.5 * size.z()), size, hal::deg_to_rad(c.yaw_deg), Label::Clutter));
    }
  }
  return shapes;
}

}  // namespace colift::sim_hal
