#include "perception/shape/shape_evidence.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "hal/types/units.hpp"
#include "perception/footprint.hpp"

namespace colift::perception {

double median_width(std::vector<double> widths) {
  const auto middle = widths.begin() + static_cast<std::ptrdiff_t>(widths.size() / 2);
  std::nth_element(widths.begin(), middle, widths.end());
  return *middle;
}

ShapeEvidence::ShapeEvidence(const OrganisedCloud& cloud, const Target& target,
                             const std::vector<Surface>& surfaces, const Ground& ground,
                             const NoiseModel& noise, const CompletionConfig& config)
    : cloud_(cloud),
      target_(target),
      surfaces_(surfaces),
      ground_(ground.plane),
      up_(ground.plane.normal),
      noise_(noise),
      config_(config) {
  for (const Surface& s : surfaces) {
    if (const auto* r = std::get_if<Rectangle>(&s)) {
      total_area_ += r->size.prod();
      const double cosine = r->normal.dot(up_);
      if (cosine > std::cos(hal::deg_to_rad(config.level_deg))) level_.push_back(r);
      if (std::abs(cosine) < config.max_lean_sine) upright_.push_back(r);
    } else {
      const auto& c = std::get<Cylinder>(s);
      const double area = 2 * c.radius * c.length;
      total_area_ += area;
      if (!cylinder_ || area > cylinder_->radius * cylinder_->length * 2) cylinder_ = &c;
    }
  }
  // find_target has measured this box already
  footprint_ = target.obb.size.minCoeff() > 0 ? target.obb : box_on_plane(target.points, ground_, BoxTrim{});
  const double distance = (footprint_.center - cloud.X_WC.translation()).norm();
  pixel_m_ = distance / cloud.intrinsics.fx;
  depth_sigma_m_ = noise.sigma(distance);
}

const Rectangle* ShapeEvidence::find_top() const {
  const double least = config_.min_top_fraction * footprint_.size[0] * footprint_.size[1];
  const Rectangle* best = nullptr;
  double best_area = least;
  for (const Rectangle* r : level_) {
    const double height = ground_.height(r->center);
    // the bottom of an open box is level and wide too, but something stands around it; its rims are narrow
    if (r->size.y() < 0.2 * config_.min_plate_m || height < 0.4 * footprint_.size[2]) continue;
    // a dark top comes in pieces
    double area = 0;
    for (const Rectangle* other : level_)
      if (std::abs(ground_.height(other->center) - height) < config_.same_level_tolerance_m)
        area += other->size.prod();
    if (area < least) continue;
    area += 0.01 * r->size.prod();  // of the same pieces the largest stands for all
    if (area > best_area) best = r, best_area = area;
  }
  return best;
}

ShapeEvidence::Widened ShapeEvidence::widened(const Rectangle& top, double below_m) const {
  Widened result{top, {0.0, 0.0}};
  Rectangle& r = result.top;
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
    const std::array<double, 2> all = points_along(e, below_m);
    const double middle = e.dot(r.center);
    double low = middle - 0.5 * r.size[axis], high = middle + 0.5 * r.size[axis];
    const auto continued = [&](double from, double to) {
      Rectangle strip = r;
      strip.center += (0.5 * (from + to) - middle) * e;
      strip.size[axis] = std::abs(to - from);
      // a handle below the top sticks out
      return gaps(strip) > config_.max_gaps ? from : to;
    };
    if (all[0] < low - margin) low = continued(low, outer_face(-e, all[0]));
    if (all[1] > high + margin) high = continued(high, -outer_face(e, -all[1]));
    r.center += (0.5 * (low + high) - middle) * e;
    result.added_m[static_cast<std::size_t>(axis)] = high - low - r.size[axis];
    r.size[axis] = high - low;
  }
  return result;
}

double ShapeEvidence::outer_face(const Vec3& out, double end) const {
  double best = end, area = 0.01;
  for (const Rectangle* x : upright_) {
    const double place = -out.dot(x->center);
    if (x->normal.dot(out) < config_.side_cosine || x->size.prod() < area ||
        std::abs(place - end) > 0.03 + 3 * depth_sigma_m_)
      continue;
    best = place, area = x->size.prod();
  }
  return best;
}

double ShapeEvidence::part_above(const Rectangle& top) const {
  const double limit = ground_.height(top.center) + config_.above_clearance_m;
  std::size_t above = 0;
  const Eigen::Vector3f up = up_.cast<float>();
  const auto least = static_cast<float>(limit - ground_.offset);
  for (const Eigen::Vector3f& p : target_.points) above += up.dot(p) > least;
  return static_cast<double>(above) / static_cast<double>(std::max<std::size_t>(1, target_.points.size()));
}

ShapeEvidence::Sight ShapeEvidence::at(const Vec3& point) const {
  const auto pixel = cloud_.project(point);
  if (!cloud_.contains(pixel.u, pixel.v)) return Sight::Unknown;
  const auto k = static_cast<std::size_t>(std::lround(pixel.v)) * static_cast<std::size_t>(cloud_.width()) +
                 static_cast<std::size_t>(std::lround(pixel.u));
  if (!cloud_.seen(k)) return Sight::Unknown;
  const double behind = static_cast<double>(cloud_.depth_m[k]) - pixel.depth_m;
  const double tolerance = 4 * noise_.sigma(pixel.depth_m) + config_.side_tolerance_m;
  if (behind > tolerance) return Sight::Empty;
  return behind > -tolerance ? Sight::There : Sight::Unknown;
}

double ShapeEvidence::gaps(const Rectangle& face) const {
  OrientedBox box;
  box.center = face.center;
  box.axes << face.u, face.v, face.normal;
  box.size = Vec3(face.size.x(), face.size.y(), 0.0);
  return gaps(box);
}

double ShapeEvidence::gaps(const OrientedBox& box) const {
  constexpr int kSteps = 12;
  int empty = 0, there = 0;
  const int layers = box.size.z() > 0.0 ? kSteps : 1;
  for (int i = 0; i < kSteps; ++i)
    for (int j = 0; j < kSteps; ++j)
      for (int k = 0; k < layers; ++k) {
        const Vec3 part((i + 0.5) / kSteps - 0.5, (j + 0.5) / kSteps - 0.5, (k + 0.5) / layers - 0.5);
        const Sight sight = at(box.center + box.axes * part.cwiseProduct(box.size));
        empty += sight == Sight::Empty, there += sight == Sight::There;
      }
  if (empty + there == 0) return std::numeric_limits<double>::quiet_NaN();
  return static_cast<double>(empty) / (empty + there);
}

double ShapeEvidence::seen_support(const Rectangle& top) const {
  const int columns = config_.side_columns, rows = config_.side_rows;
  const double edge_width = config_.max_edge_width_m;
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
      for (int i = 0; i < columns; ++i)
        for (int j = 0; j < rows; ++j) {
          // below the edge face of a plate and above the dirt on the floor
          const double down = edge_width + (height - edge_width - 0.02) * (j + 0.5) / rows;
          if (down > height) continue;
          const Vec3 p = edge + length * ((i + 0.5) / columns - 0.5) * along - down * up_;
          const Sight sight = at(p);
          empty += sight == Sight::Empty, solid += sight == Sight::There;
        }
    }
  if (solid + empty == 0) return std::numeric_limits<double>::quiet_NaN();
  return static_cast<double>(solid) / (solid + empty);
}

std::array<double, 2> ShapeEvidence::sides_along(const Vec3& e) const {
  std::array<double, 2> sides = points_along(e);
  const double middle = 0.5 * (sides[0] + sides[1]);
  for (const int end : {0, 1}) {
    const double sign = end == 0 ? -1 : 1;
    double best_area = 0, wall = 0;
    for (const Rectangle* r : upright_) {
      const double cosine = sign * r->normal.dot(e), place = e.dot(r->center);
      // the outermost quarter is where a wall of this side can be
      if (std::abs(cosine) < config_.side_cosine ||
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

std::array<double, 2> ShapeEvidence::points_along(const Vec3& e, double below_m) const {
  constexpr std::size_t kBins = 1024;
  const Eigen::Vector3f ef = e.cast<float>(), up = up_.cast<float>();
  const auto offset = static_cast<float>(ground_.offset);
  const auto most = static_cast<float>(below_m);
  const bool all = !(below_m < std::numeric_limits<double>::infinity());
  std::vector<float> places;
  places.reserve(target_.points.size() / 2 + 1);
  float low = std::numeric_limits<float>::max(), high = -low;
  for (std::size_t i = 0; i < target_.points.size(); i += 2) {
    const Eigen::Vector3f& p = target_.points[i];
    if (!all && up.dot(p) + offset > most) continue;
    const float x = ef.dot(p);
    places.push_back(x);
    low = std::min(low, x), high = std::max(high, x);
  }
  if (places.empty()) return {0.0, 0.0};
  // counts per place instead of a sort: a thousandth of an object is finer than a pixel
  std::array<std::uint32_t, kBins> count{};
  const float width = std::max(high - low, 1e-6f) / static_cast<float>(kBins), scale = 1.0f / width;
  for (const float x : places) ++count[std::min(static_cast<std::size_t>((x - low) * scale), kBins - 1)];
  const auto strays =
      static_cast<std::uint32_t>(config_.stray_fraction * static_cast<double>(places.size() - 1));
  std::size_t first = 0, last = kBins - 1;
  for (std::uint32_t n = count[first]; n <= strays && first < last; n += count[first]) ++first;
  for (std::uint32_t n = count[last]; n <= strays && first < last; n += count[last]) --last;
  return {static_cast<double>(low + (static_cast<float>(first) + 0.5f) * width),
          static_cast<double>(low + (static_cast<float>(last) + 0.5f) * width)};
}

std::optional<double> ShapeEvidence::edge_of(const Rectangle& top) const {
  const double height = ground_.height(top.center);
  const Rectangle* best = nullptr;
  for (const Rectangle* r : upright_) {
    if (r->size.y() > config_.max_edge_width_m || std::abs(r->u.dot(up_)) > 0.2) continue;
    if (std::abs(ground_.height(r->center) + 0.5 * r->size.y() - height) > 0.02 + depth_sigma_m_) continue;
    if (r->size.x() < 0.3 * top.size.y()) continue;
    if (!best || r->size.x() > best->size.x()) best = r;
  }
  if (!best) return std::nullopt;
  return best->size.y();
}

std::optional<double> ShapeEvidence::leg_width(double height) const {
  std::vector<double> widths;
  for (const Rectangle* r : upright_)
    if (std::abs(r->u.dot(up_)) > 0.95 && r->size.y() < 2.5 * config_.leg_m &&
        r->size.x() > 3 * r->size.y() && ground_.height(r->center) < height)
      widths.push_back(r->size.y());
  // a round leg has the cross-section of a square of 0.89 times its diameter
  if (cylinder_ && std::abs(cylinder_->axis.dot(up_)) > 0.95 && ground_.height(cylinder_->center) < height)
    widths.push_back(std::sqrt(std::numbers::pi) * cylinder_->radius);
  if (widths.empty()) return std::nullopt;
  return median_width(widths);
}

double ShapeEvidence::end_sigma(double length) const {
  return std::hypot(config_.edge_pixels * pixel_m_, 0.002 * length);
}

double ShapeEvidence::side_sigma(const Widened& top, int axis) const {
  const double added = top.added_m[static_cast<std::size_t>(axis)];
  return end_sigma(top.top.size[axis]) + (added > 0 ? depth_sigma_m_ + std::min(0.05 * added, 0.03) : 0.0);
}

double ShapeEvidence::level_sigma(double part) const {
  return part * std::hypot(config_.vertical_sigma_m, 0.2 * depth_sigma_m_);
}

}  // namespace colift::perception
