#include "perception/shape_completion.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

#include "perception/footprint.hpp"

namespace colift::perception {
namespace {

constexpr double kUprightSin = 0.14;        // an upright face may lean by 8 degrees
constexpr double kCylinderPart = 0.5;       // of the surfaces' area that a cylinder has to make up
constexpr double kAboveClearance_m = 0.05;  // what stands higher over a top is something on it
constexpr double kAbovePart = 0.06;         // part of the points that makes it a back
constexpr double kTopPart = 0.12;  // of the footprint that a top has to cover; rims of open boxes cover less
constexpr double kSameLevel_m = 0.02;
constexpr double kEdgeWidth_m = 0.08;
constexpr double kVerticalSigma_m = 0.002;

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// Masses of parts at uniform density.
struct Mixture {
  double mass = 0;
  Vec3 moment = Vec3::Zero();

  void add(double m, const Vec3& at) { mass += m, moment += m * at; }
  [[nodiscard]] Vec3 centroid() const { return moment / mass; }
};

class Completion {
 public:
  Completion(const OrganisedCloud& cloud, const Target& target, const std::vector<Surface>& surfaces,
             const Ground& ground, const NoiseModel& noise, const CompletionConfig& config)
      : cloud_(cloud),
        target_(target),
        ground_(ground.plane),
        up_(ground.plane.normal),
        noise_(noise),
        config_(config) {
    for (const Surface& s : surfaces) {
      if (const auto* r = std::get_if<Rectangle>(&s)) {
        total_area_ += r->size.prod();
        const double cosine = r->normal.dot(up_);
        if (cosine > std::cos(config.level_deg * std::numbers::pi / 180)) level_.push_back(r);
        if (std::abs(cosine) < kUprightSin) upright_.push_back(r);
      } else {
        const auto& c = std::get<Cylinder>(s);
        const double area = 2 * c.radius * c.length;
        total_area_ += area;
        if (!cylinder_ || area > cylinder_->radius * cylinder_->length * 2) cylinder_ = &c;
      }
    }
    footprint_ = box_on_plane(target.points, ground_, BoxTrim{});
    const double distance = (footprint_.center - cloud.X_WC.translation()).norm();
    pixel_m_ = distance / cloud.intrinsics.fx;
    depth_sigma_m_ = noise.sigma(distance);
  }

  CompletedShape run() {
    if (cylinder_ && 2 * cylinder_->radius * cylinder_->length > kCylinderPart * total_area_) return round();
    if (const Rectangle* found = find_top()) {
      const Rectangle top = widened(*found);
      if (part_above(top) > kAbovePart) return chair(top);
      const double support = seen_support(top);
      return support < config_.closed_support ? plate(top, support) : block(top, support);
    }
    if (auto open = open_box()) return *open;
    return mirrored();
  }

 private:
  // ---- what is there

  [[nodiscard]] const Rectangle* find_top() const {
    const double least = kTopPart * footprint_.size[0] * footprint_.size[1];
    const Rectangle* best = nullptr;
    double best_area = least;
    for (const Rectangle* r : level_) {
      const double height = ground_.height(r->center);
      // the bottom of an open box is level and wide too, but something stands around it; its rims are narrow
      if (r->size.y() < 0.2 * config_.min_plate_m || height < 0.4 * footprint_.size[2]) continue;
      // a dark top comes in pieces
      double area = 0;
      for (const Rectangle* other : level_)
        if (std::abs(ground_.height(other->center) - height) < kSameLevel_m) area += other->size.prod();
      if (area < least) continue;
      area += 0.01 * r->size.prod();  // of the same pieces the largest stands for all
      if (area > best_area) best = r, best_area = area;
    }
    return best;
  }

  /// The top as far as the whole object goes: where part of it gave no data or is hidden by a back, the
  /// points below or beside it still tell. Nothing of tables, boxes and chairs sticks out under their tops.
  [[nodiscard]] Rectangle widened(const Rectangle& top) {
    Rectangle r = top;
    r.u = (top.u - up_ * up_.dot(top.u)).normalized();
    r.v = up_.cross(r.u);
    r.normal = up_;
    // upright faces know the directions better than a scrap of the top does
    const Rectangle* side = nullptr;
    for (const Rectangle* x : upright_)
      if (!side || x->size.prod() > side->size.prod()) side = x;
    if (side && side->size.prod() > top.size.prod()) {
      const Vec3 n = (side->normal - up_ * up_.dot(side->normal)).normalized(), m = up_.cross(n);
      const bool along_n = std::abs(n.dot(r.u)) > std::abs(m.dot(r.u));
      r.u = along_n ? n : m;
      r.v = up_.cross(r.u);
    }
    const double margin = 2 * pixel_m_ + 2 * depth_sigma_m_;
    for (const int axis : {0, 1}) {
      const Vec3 e = axis == 0 ? r.u : r.v;
      const std::array<double, 2> all = points_along(e);
      const double middle = e.dot(r.center);
      double low = middle - 0.5 * r.size[axis], high = middle + 0.5 * r.size[axis];
      if (all[0] < low - margin) low = outer_face(-e, all[0]);
      if (all[1] > high + margin) high = -outer_face(e, -all[1]);
      r.center += (0.5 * (low + high) - middle) * e;
      widened_m_[static_cast<std::size_t>(axis)] = high - low - r.size[axis];
      r.size[axis] = high - low;
    }
    return r;
  }

  /// Coordinate against `out` of the outermost face that looks along it, when one is near the given end.
  [[nodiscard]] double outer_face(const Vec3& out, double end) const {
    double best = end, area = 0.01;
    for (const Rectangle* x : upright_) {
      const double place = -out.dot(x->center);
      if (x->normal.dot(out) < 0.96 || x->size.prod() < area ||
          std::abs(place - end) > 0.03 + 3 * depth_sigma_m_)
        continue;
      best = place, area = x->size.prod();
    }
    return best;
  }

  [[nodiscard]] double part_above(const Rectangle& top) const {
    const double limit = ground_.height(top.center) + kAboveClearance_m;
    std::size_t above = 0;
    for (const Eigen::Vector3f& p : target_.points) above += ground_.height(p.cast<double>()) > limit;
    return static_cast<double>(above) / static_cast<double>(std::max<std::size_t>(1, target_.points.size()));
  }

  /// Part of what would be the visible sides of a solid below this top at which the camera saw a surface;
  /// where it saw nothing or something nearer does not count. NaN when no side faces the camera.
  [[nodiscard]] double seen_support(const Rectangle& top) const {
    constexpr int kAcross = 24, kDown = 12;
    const double height = ground_.height(top.center);
    int solid = 0, empty = 0;
    for (const double sign : {1.0, -1.0})
      for (const bool along_u : {true, false}) {
        const Vec3 out = sign * (along_u ? top.u : top.v), along = along_u ? top.v : top.u;
        const double reach = 0.5 * (along_u ? top.size.x() : top.size.y()),
                     length = along_u ? top.size.y() : top.size.x();
        const Vec3 edge = top.center + reach * out;
        const Vec3 to_eye = cloud_.X_WC.translation() - edge;
        if (out.dot(to_eye) < 0.2 * to_eye.norm()) continue;
        for (int i = 0; i < kAcross; ++i)
          for (int j = 0; j < kDown; ++j) {
            // below the edge face of a plate and above the dirt on the floor
            const double down = kEdgeWidth_m + (height - kEdgeWidth_m - 0.02) * (j + 0.5) / kDown;
            if (down > height) continue;
            const Vec3 p = edge + length * ((i + 0.5) / kAcross - 0.5) * along - down * up_;
            const auto pixel = cloud_.project(p);
            if (!cloud_.contains(pixel.u, pixel.v)) continue;
            const auto k =
                static_cast<std::size_t>(std::lround(pixel.v)) * static_cast<std::size_t>(cloud_.width()) +
                static_cast<std::size_t>(std::lround(pixel.u));
            if (!cloud_.seen(k)) continue;
            const double behind = static_cast<double>(cloud_.depth_m[k]) - pixel.depth_m;
            const double tolerance = 4 * noise_.sigma(pixel.depth_m) + 0.02;
            if (behind > tolerance)
              ++empty;
            else if (behind > -tolerance)
              ++solid;
          }
      }
    if (solid + empty == 0) return std::numeric_limits<double>::quiet_NaN();
    return static_cast<double>(solid) / (solid + empty);
  }

  // ---- what it is

  CompletedShape round() const {
    CompletedShape s;
    s.kind = CompletedShape::Kind::Cylinder;
    Cylinder c = *cylinder_;
    const double steep = std::abs(c.axis.dot(up_));
    const double bottom = ground_.height(c.center) - 0.5 * c.length * steep;
    // cleaning takes away what is close to the ground
    const bool stands = steep > 0.98 && bottom > -0.03 && bottom < 0.04 + 3 * depth_sigma_m_;
    if (stands) {
      c.center -= 0.5 * bottom * up_;
      c.length += bottom;
    }
    s.cog = c.center;
    const auto [e1, e2] = hal::tangents(c.axis);
    s.box.center = c.center;
    s.box.axes << c.axis, e1, e2;
    s.box.size = Vec3(c.length, 2 * c.radius, 2 * c.radius);
    const double along = 2.0 * end_sigma(c.length), across = 0.05 * c.radius + 0.5 * depth_sigma_m_;
    s.covariance = spread(s.box.axes, Vec3(along, across, across));
    put_up_last(s.box);
    s.because = fmt::format("a cylinder of radius {:.0f} mm and length {:.2f} m, symmetric about its axis{}",
                            1000 * c.radius, c.length, stands ? ", standing on the ground" : "");
    return s;
  }

  CompletedShape block(const Rectangle& top, double support) const {
    CompletedShape s;
    s.kind = CompletedShape::Kind::Block;
    const double height = ground_.height(top.center);
    s.box = upright_box(top, height);
    s.cog = s.box.center;
    s.covariance = spread(s.box.axes, Vec3(side_sigma(top, 0), side_sigma(top, 1), level_sigma(0.5)));
    // without a look at the sides it may as well be a plate
    if (!(support == support)) s.covariance += 0.04 * height * height * up_ * up_.transpose();
    s.because = support == support
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

  CompletedShape plate(const Rectangle& top, double support) const {
    CompletedShape s;
    s.kind = CompletedShape::Kind::Plate;
    const double height = ground_.height(top.center);
    const auto thickness = edge_of(top);
    const double t = thickness.value_or(config_.thickness_m);
    const auto leg = leg_width(height - t);
    const double a = leg.value_or(config_.leg_m);
    Mixture m;
    m.add(top.size.prod() * t, top.center - 0.5 * t * up_);
    m.add(4 * a * a * (height - t), ground_.foot(top.center) + 0.5 * (height - t) * up_);
    s.cog = m.centroid();
    s.box = upright_box(top, height);
    // mass that may be in the legs or in the top moves the centroid up and down by this
    const double in_legs = 4 * a * a * (height - t) / m.mass;
    const double doubt = (thickness ? 0.12 : 0.3) + (leg ? 0.15 : 0.4);
    const double vertical = std::hypot(level_sigma(1.0), doubt * in_legs * (1 - in_legs) * 0.5 * height);
    s.covariance = spread(s.box.axes, Vec3(side_sigma(top, 0), side_sigma(top, 1), vertical));
    s.because = fmt::format(
        "a {:.2f} x {:.2f} m plate, {:.0f} mm thick{}, {:.2f} m over the ground on four legs of {:.0f} mm{}: "
        "{:.0f} % of the sides of a closed body would be there",
        top.size.x(), top.size.y(), 1000 * t, thickness ? "" : " (assumed)", height, 1000 * a,
        leg ? "" : " (assumed)", 100 * support);
    return s;
  }

  CompletedShape chair(const Rectangle& seat) const {
    CompletedShape s;
    s.kind = CompletedShape::Kind::Chair;
    const double height = ground_.height(seat.center);
    const double t = edge_of(seat).value_or(config_.thickness_m);
    const double a = leg_width(height - t).value_or(config_.leg_m);

    // the back: upright faces above the seat that look the same way, not both sides of the same post
    const Rectangle* main = nullptr;
    for (const Rectangle* r : upright_)
      if (ground_.height(r->center) > height + 0.03 && (!main || r->size.prod() > main->size.prod()))
        main = r;
    Mixture m, back;
    Vec3 out = Vec3::Zero();
    if (main) {
      out = (main->normal - up_ * up_.dot(main->normal)).normalized();
      for (const Rectangle* r : upright_)
        if (ground_.height(r->center) > height + 0.03 && std::abs(r->normal.dot(out)) > 0.9)
          back.add(r->size.prod() * config_.thickness_m, r->center - 0.5 * config_.thickness_m * r->normal);
    } else {
      // too broken up for faces: what is seen of it, as thick as a plate
      for (std::size_t i = 0; i < target_.points.size(); ++i) {
        const Vec3 p = target_.points[i].cast<double>();
        if (ground_.height(p) > height + kAboveClearance_m)
          back.add(pixel_m_ * pixel_m_ * config_.thickness_m, p);
      }
    }
    const Vec3 floor = ground_.foot(seat.center);
    m.add(seat.size.prod() * t, seat.center - 0.5 * t * up_);
    m.add(4 * a * a * (height - t), floor + 0.5 * (height - t) * up_);
    if (back.mass > 0) {
      Vec3 at = back.centroid();
      if (main) {
        // symmetric about the seat's middle: the back's middle lies where the seat's is across the chair
        const Vec3 across = up_.cross(out);
        at += across * across.dot(seat.center - at);
      }
      m.add(back.mass, at);
    }
    s.cog = m.centroid();
    s.box = footprint_;
    const double horizontal =
        std::max(config_.shape_sigma * 0.5 * footprint_.size.head<2>().maxCoeff(), end_sigma(seat.size.x()));
    s.covariance = spread(s.box.axes, Vec3(horizontal, horizontal, config_.shape_sigma * footprint_.size[2]));
    s.because = fmt::format(
        "a {:.2f} x {:.2f} m seat {:.2f} m over the ground with a back of {:.0f} cm2 seen above it and four "
        "legs, symmetric about the seat's middle",
        seat.size.x(), seat.size.y(), height, 1e4 * back.mass / config_.thickness_m);
    return s;
  }

  // Walls and a bottom, seen from above: faces that look inwards at each other.
  [[nodiscard]] std::optional<CompletedShape> open_box() const {
    if (upright_.empty()) return std::nullopt;
    const Rectangle* largest = *std::max_element(
        upright_.begin(), upright_.end(),
        [](const Rectangle* x, const Rectangle* y) { return x->size.prod() < y->size.prod(); });
    const Vec3 e1 = (largest->normal - up_ * up_.dot(largest->normal)).normalized(), e2 = up_.cross(e1);
    const Vec3 middle = footprint_.center;
    double inward = 0, outward = 0;
    for (const Rectangle* r : upright_)
      (r->normal.dot(r->center - middle) < 0 ? inward : outward) += r->size.prod();
    double bottom = 0;
    for (const Rectangle* r : level_)
      if (ground_.height(r->center) < 0.25 * footprint_.size[2]) bottom += r->size.prod();
    if (inward + bottom < 0.15 * (inward + outward + bottom)) return std::nullopt;

    const std::array<double, 2> side1 = sides_along(e1), side2 = sides_along(e2);
    std::vector<double> heights;
    for (std::size_t i = 0; i < target_.points.size(); i += 4)
      heights.push_back(ground_.height(target_.points[i].cast<double>()));
    const auto top =
        heights.begin() + static_cast<std::ptrdiff_t>(0.985 * static_cast<double>(heights.size() - 1));
    std::nth_element(heights.begin(), top, heights.end());
    const double h = *top, w = side1[1] - side1[0], d = side2[1] - side2[0], t = config_.wall_m;
    if (!(w > 0 && d > 0 && h > 0)) return std::nullopt;

    CompletedShape s;
    s.kind = CompletedShape::Kind::OpenBox;
    const Vec3 zero = ground_.foot(Vec3::Zero());
    const Vec3 floor = zero + (0.5 * (side1[0] + side1[1])) * e1 + (0.5 * (side2[0] + side2[1])) * e2 -
                       e1 * e1.dot(zero) - e2 * e2.dot(zero);
    Mixture m;
    m.add(2 * (w + d) * t * h, floor + 0.5 * h * up_);
    m.add(w * d * t, floor + 0.5 * t * up_);
    s.cog = m.centroid();
    s.box.axes << e1, e2, up_;
    s.box.size = Vec3(w, d, h);
    s.box.center = floor + 0.5 * h * up_;
    const double wall = std::hypot(0.7 * end_sigma(std::max(w, d)), 0.1 * t);
    s.covariance = spread(s.box.axes, Vec3(wall, wall, std::hypot(level_sigma(1.0), 0.01 * h)));
    s.because = fmt::format(
        "an open box, {:.2f} x {:.2f} x {:.2f} m: {:.0f} % of the upright faces look inwards; four walls and "
        "a bottom, all {:.0f} mm thick, were assumed",
        w, d, h, 100 * inward / (inward + outward), 1000 * t);
    return s;
  }

  /// Outer sides along a horizontal direction: from an outer face, from an inner face and the wall behind it,
  /// else from the outermost points.
  [[nodiscard]] std::array<double, 2> sides_along(const Vec3& e) const {
    constexpr double kSame = 0.96;
    std::array<double, 2> sides = points_along(e);
    const double middle = 0.5 * (sides[0] + sides[1]);
    for (const int end : {0, 1}) {
      const double sign = end == 0 ? -1 : 1;
      double best_area = 0, wall = 0;
      for (const Rectangle* r : upright_) {
        const double cosine = sign * r->normal.dot(e), place = e.dot(r->center);
        // the outermost quarter is where a wall of this side can be
        if (std::abs(cosine) < kSame ||
            sign * (place - middle) < 0.5 * sign * (sides[static_cast<std::size_t>(end)] - middle))
          continue;
        if (r->size.prod() <= best_area) continue;
        best_area = r->size.prod();
        wall = cosine > 0 ? place : place + sign * config_.wall_m;
      }
      if (best_area > 0.01) sides[static_cast<std::size_t>(end)] = wall;
    }
    return sides;
  }

  /// How far the points go along a direction, without strays.
  [[nodiscard]] std::array<double, 2> points_along(const Vec3& e) const {
    std::vector<float> all;
    all.reserve(target_.points.size() / 2 + 1);
    const Eigen::Vector3f ef = e.cast<float>();
    for (std::size_t i = 0; i < target_.points.size(); i += 2) all.push_back(ef.dot(target_.points[i]));
    if (all.empty()) return {0.0, 0.0};
    const auto at = [&](double part) {
      const auto k = all.begin() + static_cast<std::ptrdiff_t>(part * static_cast<double>(all.size() - 1));
      std::nth_element(all.begin(), k, all.end());
      return static_cast<double>(*k);
    };
    return {at(0.004), at(0.996)};
  }

  CompletedShape mirrored() const {
    CompletedShape s;
    s.kind = CompletedShape::Kind::Mirrored;
    s.box = footprint_;
    double height = 0;
    for (const Eigen::Vector3f& p : target_.points) height += ground_.height(p.cast<double>());
    height /= static_cast<double>(std::max<std::size_t>(1, target_.points.size()));
    // the camera sees the near side only: between as deep as seen and as deep as wide, the middle is the best
    // guess
    const Vec3 to_object = footprint_.center - cloud_.X_WC.translation();
    const Vec3 ahead = (to_object - up_ * up_.dot(to_object)).normalized(), across = up_.cross(ahead);
    const auto deep = points_along(ahead), wide = points_along(across);
    const double hidden = std::max(0.0, (wide[1] - wide[0]) - (deep[1] - deep[0]));
    const double pushed = 0.25 * hidden;
    s.cog = ground_.foot(footprint_.center) + pushed * ahead + height * up_;
    s.box.center += pushed * ahead;
    s.covariance =
        spread(footprint_.axes, 2 * config_.shape_sigma * footprint_.size + Vec3::Constant(pixel_m_)) +
        pushed * pushed * ahead * ahead.transpose();
    s.because = fmt::format(
        "no known shape: what was seen is mirrored about the middle of its {:.2f} x {:.2f} m footprint, "
        "moved {:.0f} mm away from the camera for its hidden side",
        footprint_.size[0], footprint_.size[1], 1000 * pushed);
    return s;
  }

  // ---- measures

  /// Thickness of a plate from a narrow upright face along one of its sides.
  [[nodiscard]] std::optional<double> edge_of(const Rectangle& top) const {
    const double height = ground_.height(top.center);
    const Rectangle* best = nullptr;
    for (const Rectangle* r : upright_) {
      if (r->size.y() > kEdgeWidth_m || std::abs(r->u.dot(up_)) > 0.2) continue;
      if (std::abs(ground_.height(r->center) + 0.5 * r->size.y() - height) > 0.02 + depth_sigma_m_) continue;
      if (r->size.x() < 0.3 * top.size.y()) continue;
      if (!best || r->size.x() > best->size.x()) best = r;
    }
    if (!best) return std::nullopt;
    return best->size.y();
  }

  /// Width of legs from upright narrow faces and thin upright cylinders below a height.
  [[nodiscard]] std::optional<double> leg_width(double height) const {
    std::vector<double> widths;
    for (const Rectangle* r : upright_)
      if (std::abs(r->u.dot(up_)) > 0.95 && r->size.y() < 2.5 * config_.leg_m &&
          r->size.x() > 3 * r->size.y() && ground_.height(r->center) < height)
        widths.push_back(r->size.y());
    // a round leg has the cross-section of a square of 0.89 times its diameter
    if (cylinder_ && std::abs(cylinder_->axis.dot(up_)) > 0.95 && ground_.height(cylinder_->center) < height)
      widths.push_back(std::sqrt(std::numbers::pi) * cylinder_->radius);
    if (widths.empty()) return std::nullopt;
    return median(widths);
  }

  /// Of the middle between two edges.
  [[nodiscard]] double end_sigma(double length) const {
    return std::hypot(config_.edge_pixels * pixel_m_, 0.002 * length);
  }
  /// The same for a top; where it had to be continued to points of other faces, by noise and rags of those.
  [[nodiscard]] double side_sigma(const Rectangle& top, int axis) const {
    const double added = widened_m_[static_cast<std::size_t>(axis)];
    return end_sigma(top.size[axis]) + (added > 0 ? depth_sigma_m_ + std::min(0.05 * added, 0.03) : 0.0);
  }
  /// Of a height that a plane of many pixels gives.
  [[nodiscard]] double level_sigma(double part) const {
    return part * std::hypot(kVerticalSigma_m, 0.2 * depth_sigma_m_);
  }

  static Eigen::Matrix3d spread(const Eigen::Matrix3d& axes, const Vec3& sigma) {
    return axes * sigma.cwiseAbs2().asDiagonal() * axes.transpose();
  }

  [[nodiscard]] OrientedBox upright_box(const Rectangle& top, double height) const {
    OrientedBox box;
    const Vec3 u = (top.u - up_ * up_.dot(top.u)).normalized();
    box.axes << u, up_.cross(u), up_;
    box.size = Vec3(top.size.x(), top.size.y(), height);
    box.center = top.center - 0.5 * height * up_;
    return box;
  }

  void put_up_last(OrientedBox& box) const {
    Vec3::Index steepest;
    (box.axes.transpose() * up_).cwiseAbs().maxCoeff(&steepest);
    if (steepest == 2) return;
    // the axes turn round in a ring, so they stay right-handed
    const Eigen::Matrix3d axes = box.axes;
    const Vec3 size = box.size;
    for (Vec3::Index i = 0; i < 3; ++i) {
      box.axes.col(i) = axes.col((steepest + 1 + i) % 3);
      box.size[i] = size[(steepest + 1 + i) % 3];
    }
  }

  const OrganisedCloud& cloud_;
  const Target& target_;
  hal::Plane ground_;
  Vec3 up_;
  const NoiseModel& noise_;
  const CompletionConfig& config_;
  std::vector<const Rectangle*> level_, upright_;
  const Cylinder* cylinder_ = nullptr;
  double total_area_ = 0, pixel_m_ = 0, depth_sigma_m_ = 0;
  OrientedBox footprint_;
  std::array<double, 2> widened_m_{0.0, 0.0};  // by how much the top had to be continued along its sides
};

}  // namespace

CompletedShape complete_shape(const OrganisedCloud& cloud, const Target& target,
                              const std::vector<Surface>& surfaces, const Ground& ground,
                              const NoiseModel& noise, const CompletionConfig& config) {
  return Completion(cloud, target, surfaces, ground, noise, config).run();
}

const char* name_of(CompletedShape::Kind kind) {
  switch (kind) {
    case CompletedShape::Kind::Block:
      return "block";
    case CompletedShape::Kind::Plate:
      return "plate on legs";
    case CompletedShape::Kind::OpenBox:
      return "open box";
    case CompletedShape::Kind::Cylinder:
      return "cylinder";
    case CompletedShape::Kind::Chair:
      return "chair";
    case CompletedShape::Kind::Mirrored:
      return "mirrored";
  }
  return "";
}

}  // namespace colift::perception
