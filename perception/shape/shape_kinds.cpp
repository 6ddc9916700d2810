#include "perception/shape/shape_kinds.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "perception/shape/chair_back.hpp"

namespace colift::perception {
namespace {

/// Masses of parts at uniform density.
struct Mixture {
  double mass = 0;
  Vec3 moment = Vec3::Zero();

  void add(double m, const Vec3& at) { mass += m, moment += m * at; }
  [[nodiscard]] Vec3 centroid() const { return moment / mass; }
};

OrientedBox upright_box(const Rectangle& top, double height, const Vec3& up) {
  OrientedBox box;
  const Vec3 u = (top.u - up * up.dot(top.u)).normalized();
  box.axes << u, up.cross(u), up;
  box.size = Vec3(top.size.x(), top.size.y(), height);
  box.center = top.center - 0.5 * height * up;
  return box;
}

void put_up_last(OrientedBox& box, const Vec3& up) {
  Vec3::Index steepest;
  (box.axes.transpose() * up).cwiseAbs().maxCoeff(&steepest);
  if (steepest == 2) return;
  // the axes turn round in a ring, so they stay right-handed
  const Eigen::Matrix3d axes = box.axes;
  const Vec3 size = box.size;
  for (Vec3::Index i = 0; i < 3; ++i) {
    box.axes.col(i) = axes.col((steepest + 1 + i) % 3);
    box.size[i] = size[(steepest + 1 + i) % 3];
  }
}

}  // namespace

Eigen::Matrix3d spread(const Eigen::Matrix3d& axes, const Vec3& sigma) {
  return axes * sigma.cwiseAbs2().asDiagonal() * axes.transpose();
}

CompletedShape complete_cylinder(const ShapeEvidence& seen, const CompletionConfig& config) {
  const Vec3& up = seen.up();
  const hal::Plane& ground = seen.ground();
  CompletedShape s;
  s.kind = CompletedShape::Kind::Cylinder;
  Cylinder c = *seen.cylinder();
  const double steep = std::abs(c.axis.dot(up));
  const double bottom = ground.height(c.center) - 0.5 * c.length * steep;
  // cleaning takes away what is close to the ground
  const bool stands =
      steep > 0.98 && bottom > -0.03 && bottom < config.standing_gap_m + 3 * seen.depth_sigma_m();
  if (stands) {
    c.center -= 0.5 * bottom * up;
    c.length += bottom;
  }
  s.cog = c.center;
  const auto [e1, e2] = hal::tangents(c.axis);
  s.box.center = c.center;
  s.box.axes << c.axis, e1, e2;
  s.box.size = Vec3(c.length, 2 * c.radius, 2 * c.radius);
  const double along = 2.0 * seen.end_sigma(c.length), across = 0.02 * c.radius + 0.15 * seen.depth_sigma_m();
  s.covariance = spread(s.box.axes, Vec3(along, across, across));
  put_up_last(s.box, up);
  s.reason = fmt::format("a cylinder of radius {:.0f} mm and length {:.2f} m, symmetric about its axis{}",
                         1000 * c.radius, c.length, stands ? ", standing on the ground" : "");
  return s;
}

CompletedShape complete_block(const ShapeEvidence& seen, const ShapeEvidence::Widened& widened,
                              double support) {
  const Vec3& up = seen.up();
  const hal::Plane& ground = seen.ground();
  const Rectangle& top = widened.top;
  CompletedShape s;
  s.kind = CompletedShape::Kind::Block;
  const double height = ground.height(top.center);
  s.box = upright_box(top, height, up);
  s.cog = s.box.center;
  s.covariance = spread(
      s.box.axes, Vec3(seen.side_sigma(widened, 0), seen.side_sigma(widened, 1), seen.level_sigma(0.5)));
  // without a look at the sides it may as well be a plate
  if (!(support == support)) s.covariance += 0.04 * height * height * up * up.transpose();
  s.reason = support == support
                 ? fmt::format(
                       "a closed body under its {:.2f} x {:.2f} m top: {:.0f} % of the sides that face "
                       "the camera were seen; continued to the ground {:.2f} m below",
                       top.size.x(), top.size.y(), 100 * support, height)
                 : fmt::format(
                       "no side of what lies under its {:.2f} x {:.2f} m top was in view: taken as a "
                       "closed body down to the ground {:.2f} m below",
                       top.size.x(), top.size.y(), height);
  return s;
}

CompletedShape complete_plate(const ShapeEvidence& seen, const ShapeEvidence::Widened& widened,
                              double support, const CompletionConfig& config) {
  const Vec3& up = seen.up();
  const hal::Plane& ground = seen.ground();
  const Rectangle& top = widened.top;
  CompletedShape s;
  s.kind = CompletedShape::Kind::Plate;
  const double height = ground.height(top.center);
  const auto thickness = seen.edge_of(top);
  const double t = thickness.value_or(config.thickness_m);
  const auto leg = seen.leg_width(height - t);
  const double a = leg.value_or(config.leg_m);
  Mixture m;
  m.add(top.size.prod() * t, top.center - 0.5 * t * up);
  m.add(4 * a * a * (height - t), ground.foot(top.center) + 0.5 * (height - t) * up);
  s.cog = m.centroid();
  s.box = upright_box(top, height, up);
  // mass that may be in the legs or in the top moves the centroid up and down by this
  const double in_legs = 4 * a * a * (height - t) / m.mass;
  const double doubt = (thickness ? 0.12 : 0.3) + (leg ? 0.15 : 0.4);
  const double vertical = std::hypot(seen.level_sigma(1.0), doubt * in_legs * (1 - in_legs) * 0.5 * height);
  s.covariance = spread(s.box.axes, Vec3(seen.side_sigma(widened, 0), seen.side_sigma(widened, 1), vertical));
  s.reason = fmt::format(
      "a {:.2f} x {:.2f} m plate, {:.0f} mm thick{}, {:.2f} m over the ground on four legs of {:.0f} mm{}: "
      "{:.0f} % of the sides of a closed body would be there",
      top.size.x(), top.size.y(), 1000 * t, thickness ? "" : " (assumed)", height, 1000 * a,
      leg ? "" : " (assumed)", 100 * support);
  return s;
}

CompletedShape complete_chair(const ShapeEvidence& seen, const Rectangle& seat,
                              const CompletionConfig& config) {
  const Vec3& up = seen.up();
  const hal::Plane& ground = seen.ground();
  CompletedShape s;
  s.kind = CompletedShape::Kind::Chair;
  const double height = ground.height(seat.center);
  const double t = seen.edge_of(seat).value_or(config.thickness_m);
  const double a = seen.leg_width(height - t).value_or(config.leg_m);

  Mixture m;
  m.add(seat.size.prod() * t, seat.center - 0.5 * t * up);
  m.add(4 * a * a * (height - t), ground.foot(seat.center) + 0.5 * (height - t) * up);
  s.box = seen.footprint();
  const double side = 0.5 * config.shape_sigma * seat.size.maxCoeff() * 0.5 + seen.end_sigma(seat.size.x());
  s.covariance = spread(s.box.axes, Vec3(side, side, 0.5 * config.shape_sigma * height));
  std::string with = "without a back";
  if (const auto back = find_chair_back(seen, seat, config)) {
    const Vec3 rest = m.centroid();
    const double area = back->fill * back->width_m * back->height_m;
    m.add(area * config.thickness_m, back->center);
    // heavier or lighter than it looks, it moves the centroid along the line to it
    const double part = area * config.thickness_m / m.mass;
    const Vec3 shift = part * (1 - part) * back->relative_sigma * (back->center - rest);
    s.covariance += shift * shift.transpose();
    with = fmt::format("with a back of {:.0f} cm2, {:.0f} % of its {:.2f} x {:.2f} m {}", 1e4 * area,
                       100 * back->fill, back->width_m, back->height_m,
                       back->seen_from_front ? "seen" : "assumed");
  }
  s.cog = m.centroid();
  s.reason = fmt::format(
      "a {:.2f} x {:.2f} m seat {:.2f} m over the ground {} and four legs, symmetric about the seat's middle",
      seat.size.x(), seat.size.y(), height, with);
  return s;
}

std::optional<CompletedShape> complete_open_box(const ShapeEvidence& seen, const CompletionConfig& config) {
  const Vec3& up = seen.up();
  const hal::Plane& ground = seen.ground();
  if (seen.upright().empty()) return std::nullopt;
  const Rectangle* largest = *std::max_element(
      seen.upright().begin(), seen.upright().end(),
      [](const Rectangle* x, const Rectangle* y) { return x->size.prod() < y->size.prod(); });
  const Vec3 e1 = (largest->normal - up * up.dot(largest->normal)).normalized(), e2 = up.cross(e1);
  const Vec3 middle = seen.footprint().center;
  double inward = 0, outward = 0;
  for (const Rectangle* r : seen.upright())
    (r->normal.dot(r->center - middle) < 0 ? inward : outward) += r->size.prod();
  double bottom = 0;
  for (const Rectangle* r : seen.level())
    if (ground.height(r->center) < config.max_bottom_height * seen.footprint().size[2])
      bottom += r->size.prod();
  if (inward + bottom < config.min_inward_fraction * (inward + outward + bottom)) return std::nullopt;

  const std::array<double, 2> side1 = seen.sides_along(e1), side2 = seen.sides_along(e2);
  std::vector<double> heights;
  for (std::size_t i = 0; i < seen.target().points.size(); i += 4)
    heights.push_back(ground.height(seen.target().points[i].cast<double>()));
  const auto top =
      heights.begin() + static_cast<std::ptrdiff_t>(0.985 * static_cast<double>(heights.size() - 1));
  std::nth_element(heights.begin(), top, heights.end());
  const double h = *top, w = side1[1] - side1[0], d = side2[1] - side2[0], t = config.wall_m;
  if (!(w > 0 && d > 0 && h > 0)) return std::nullopt;
  // bars around an empty middle are no walls
  if (inward + outward < config.min_wall_fraction * (w + d) * h) return std::nullopt;

  CompletedShape s;
  s.kind = CompletedShape::Kind::OpenBox;
  const Vec3 zero = ground.foot(Vec3::Zero());
  const Vec3 floor = zero + (0.5 * (side1[0] + side1[1])) * e1 + (0.5 * (side2[0] + side2[1])) * e2 -
                     e1 * e1.dot(zero) - e2 * e2.dot(zero);
  Mixture m;
  m.add(2 * (w + d) * t * h, floor + 0.5 * h * up);
  m.add(w * d * t, floor + 0.5 * t * up);
  s.cog = m.centroid();
  s.box.axes << e1, e2, up;
  s.box.size = Vec3(w, d, h);
  s.box.center = floor + 0.5 * h * up;
  const double wall = std::hypot(0.7 * seen.end_sigma(std::max(w, d)), 0.1 * t);
  s.covariance = spread(s.box.axes, Vec3(wall, wall, std::hypot(seen.level_sigma(1.0), 0.01 * h)));
  s.reason = fmt::format(
      "an open box, {:.2f} x {:.2f} x {:.2f} m: {:.0f} % of the upright faces look inwards; four walls and "
      "a bottom, all {:.0f} mm thick, were assumed",
      w, d, h, 100 * inward / (inward + outward), 1000 * t);
  return s;
}

CompletedShape complete_mirrored(const ShapeEvidence& seen, const CompletionConfig& config) {
  const Vec3& up = seen.up();
  const hal::Plane& ground = seen.ground();
  CompletedShape s;
  s.kind = CompletedShape::Kind::Mirrored;
  s.box = seen.footprint();
  double height = 0;
  for (const Eigen::Vector3f& p : seen.target().points) height += ground.height(p.cast<double>());
  height /= static_cast<double>(std::max<std::size_t>(1, seen.target().points.size()));
  // the camera sees the near side only: between as deep as seen and as deep as wide, the middle is the best
  // guess
  const Vec3 to_object = seen.footprint().center - seen.eye();
  const Vec3 ahead = (to_object - up * up.dot(to_object)).normalized(), across = up.cross(ahead);
  const auto deep = seen.points_along(ahead), wide = seen.points_along(across);
  const double hidden = std::max(0.0, (wide[1] - wide[0]) - (deep[1] - deep[0]));
  const double pushed = 0.25 * hidden;
  s.cog = ground.foot(seen.footprint().center) + pushed * ahead + height * up;
  s.box.center += pushed * ahead;
  s.covariance = spread(seen.footprint().axes,
                        2 * config.shape_sigma * seen.footprint().size + Vec3::Constant(seen.pixel_m())) +
                 pushed * pushed * ahead * ahead.transpose();
  s.reason = fmt::format(
      "no known shape: what was seen is mirrored about the middle of its {:.2f} x {:.2f} m footprint, "
      "moved {:.0f} mm away from the camera for its hidden side",
      seen.footprint().size[0], seen.footprint().size[1], 1000 * pushed);
  return s;
}

}  // namespace colift::perception
