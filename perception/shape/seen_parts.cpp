#include "perception/shape/seen_parts.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "perception/shape/shape_kinds.hpp"

namespace colift::perception {
namespace {

using Sight = ShapeEvidence::Sight;

constexpr double kSample_m = 0.03;  // a part's place is sampled at such steps
constexpr int kMax_samples = 32;
constexpr double kFloor_m = 0.01;   // a face as low is left of the floor, not of the object
constexpr double kSlack_m = 0.005;  // of what lies in a board that was seen before
constexpr double kThinnest_m = 0.008, kThickest_m = 0.06;
constexpr double kFull_radius_m = 0.06;  // thicker tubes are hollow
constexpr std::size_t kEvery = 4;        // of the points that lie on no face

/// Mass (as volume, m^3) and place of one part, with what of it is on the hidden side.
struct Part {
  double seen = 0.0, hidden = 0.0;
  Vec3 seen_moment = Vec3::Zero(), hidden_moment = Vec3::Zero();
};

double narrow_side(const Surface& s) {
  const auto* r = std::get_if<Rectangle>(&s);
  return r ? r->size.minCoeff() : 2.0 * std::get<Cylinder>(s).radius;
}

double typical_thickness(const ShapeEvidence& seen, const CompletionConfig& config) {
  std::vector<double> widths;
  for (const Surface& s : seen.surfaces()) {
    const auto* r = std::get_if<Rectangle>(&s);
    const double width = narrow_side(s);
    const double length = r ? r->size.maxCoeff() : std::get<Cylinder>(s).length;
    if (width <= config.max_edge_width_m && length > 2.0 * width) widths.push_back(width);
  }
  if (widths.empty()) return config.thickness_m;
  return std::clamp(median_width(widths), kThinnest_m, kThickest_m);
}

bool lies_on(const Vec3& p, const Surface& s, double tolerance_m) {
  if (const auto* r = std::get_if<Rectangle>(&s)) {
    const Vec3 d = p - r->center;
    return std::abs(d.dot(r->normal)) < tolerance_m &&
           std::abs(d.dot(r->u)) < 0.5 * r->size.x() + tolerance_m &&
           std::abs(d.dot(r->v)) < 0.5 * r->size.y() + tolerance_m;
  }
  const auto& c = std::get<Cylinder>(s);
  const Vec3 d = p - c.center;
  return d.cross(c.axis).norm() < c.radius + tolerance_m &&
         std::abs(d.dot(c.axis)) < 0.5 * c.length + tolerance_m;
}

/// What lies behind a face, as deep as it is thick.
struct Slab {
  Rectangle face;
  double deep_m;

  [[nodiscard]] bool contains(const Vec3& p) const {
    const Vec3 d = p - face.center;
    const double inside = -d.dot(face.normal);
    return inside > -kSlack_m && inside < deep_m + kSlack_m &&
           std::abs(d.dot(face.u)) < 0.5 * face.size.x() && std::abs(d.dot(face.v)) < 0.5 * face.size.y();
  }
};

class PartList {
 public:
  PartList(const ShapeEvidence& seen, const Vec3& middle) : seen_(seen), middle_(middle) {}

  void begin() { parts_.emplace_back(); }
  /// Ends a part; what later faces show of the same board or bar counts once.
  void end(const Slab& slab) { slabs_.push_back(slab); }

  void add(double volume, const Vec3& at) {
    if (std::any_of(slabs_.begin(), slabs_.end(), [&](const Slab& s) { return s.contains(at); })) return;
    Part& part = parts_.back();
    part.seen += volume, part.seen_moment += volume * at;
    const Vec3& up = seen_.up();
    const Vec3 away = at - middle_, level = away - up * up.dot(away);
    const Vec3 opposite = at - 2.0 * level;
    if (seen_.at(opposite) == Sight::Unknown) part.hidden += volume, part.hidden_moment += volume * opposite;
  }

  /// Without an opposite.
  void add_alone(double volume, const Vec3& at) {
    parts_.back().seen += volume, parts_.back().seen_moment += volume * at;
  }

  [[nodiscard]] const std::vector<Part>& parts() const { return parts_; }

 private:
  const ShapeEvidence& seen_;
  Vec3 middle_;
  std::vector<Part> parts_;
  std::vector<Slab> slabs_;
};

void add_face(PartList& parts, const Rectangle& r, double thickness_m) {
  parts.begin();
  const double deep = std::min(thickness_m, r.size.minCoeff());
  const int columns = std::clamp(static_cast<int>(r.size.x() / kSample_m), 1, kMax_samples);
  const int rows = std::clamp(static_cast<int>(r.size.y() / kSample_m), 1, kMax_samples);
  const double volume = r.size.prod() * r.fill * deep / (columns * rows);
  for (int i = 0; i < columns; ++i)
    for (int j = 0; j < rows; ++j)
      parts.add(volume, r.center + ((i + 0.5) / columns - 0.5) * r.size.x() * r.u +
                            ((j + 0.5) / rows - 0.5) * r.size.y() * r.v - 0.5 * deep * r.normal);
  parts.end({r, deep});
}

void add_round(PartList& parts, const Cylinder& c, double thickness_m) {
  parts.begin();
  const double area = c.radius < kFull_radius_m
                          ? std::numbers::pi * c.radius * c.radius
                          : 2.0 * std::numbers::pi * c.radius * std::min(thickness_m, c.radius);
  const int steps = std::clamp(static_cast<int>(c.length / kSample_m), 1, kMax_samples);
  for (int i = 0; i < steps; ++i)
    parts.add(area * c.length / steps, c.center + ((i + 0.5) / steps - 0.5) * c.length * c.axis);
}

/// What is seen of the object and belongs to no face: as deep as other parts are thick.
void add_rest(PartList& parts, const ShapeEvidence& seen, double thickness_m) {
  parts.begin();
  const OrganisedCloud& cloud = seen.cloud();
  const double tolerance_m = 0.01 + 3.0 * seen.depth_sigma_m();
  const double pixel_rad2 = 1.0 / (cloud.intrinsics.fx * cloud.intrinsics.fy);
  const auto& points = seen.target().points;
  for (std::size_t i = 0; i < points.size(); i += kEvery) {
    const Vec3 p = points[i].cast<double>();
    const auto on = [&](const Surface& s) { return lies_on(p, s, tolerance_m); };
    if (std::any_of(seen.surfaces().begin(), seen.surfaces().end(), on)) continue;
    const double away = (p - seen.eye()).norm();
    const Vec3 sight = (p - seen.eye()) / away;
    parts.add(kEvery * away * away * pixel_rad2 * thickness_m, p + 0.5 * thickness_m * sight);
  }
}

bool belongs_to(const Rectangle& top, const Surface& s, const ShapeEvidence& seen,
                const CompletionConfig& config) {
  const auto* r = std::get_if<Rectangle>(&s);
  return r && r->normal.dot(seen.up()) > 0.9 &&
         std::abs(seen.ground().height(r->center) - seen.ground().height(top.center)) <
             config.same_level_tolerance_m;
}

/// Left of the floor at the object's feet.
bool is_floor(const Surface& s, const ShapeEvidence& seen) {
  const auto* r = std::get_if<Rectangle>(&s);
  return r && r->normal.dot(seen.up()) > 0.9 && seen.ground().height(r->center) < kFloor_m;
}

/// Width of the narrow face along the rim of a board; else the usual thickness.
double thickness_of(const Rectangle& board, const ShapeEvidence& seen, double usual_m,
                    const CompletionConfig& config) {
  if (board.size.minCoeff() <= config.max_edge_width_m) return board.size.minCoeff();
  double thickness_m = usual_m, longest_m = 0.0;
  for (const Surface& s : seen.surfaces()) {
    const auto* edge = std::get_if<Rectangle>(&s);
    if (!edge) continue;
    const double width = edge->size.minCoeff(), length = edge->size.maxCoeff();
    const Vec3 across = edge->size.x() < edge->size.y() ? edge->u : edge->v;
    if (width > config.max_edge_width_m || length < longest_m || std::abs(across.dot(board.normal)) < 0.9)
      continue;
    const Vec3 d = edge->center - board.center;
    const double tolerance_m = config.side_tolerance_m + seen.depth_sigma_m();
    if (std::abs(-d.dot(board.normal) - 0.5 * width) > tolerance_m) continue;
    // beside the board: within its size along one direction, at its rim along the other
    const double u = std::abs(d.dot(board.u)) - 0.5 * board.size.x(),
                 v = std::abs(d.dot(board.v)) - 0.5 * board.size.y();
    if (std::abs(std::max(u, v)) > tolerance_m) continue;
    longest_m = length, thickness_m = width;
  }
  return thickness_m;
}

}  // namespace

bool has_panels(const ShapeEvidence& seen, const Rectangle& top, const CompletionConfig& config) {
  const double height = seen.ground().height(top.center);
  return std::any_of(seen.surfaces().begin(), seen.surfaces().end(), [&](const Surface& s) {
    const auto* r = std::get_if<Rectangle>(&s);
    return r && !belongs_to(top, s, seen, config) && !is_floor(s, seen) &&
           r->size.minCoeff() > config.min_panel_m && seen.ground().height(r->center) < height;
  });
}

CompletedShape complete_parts(const ShapeEvidence& seen, const ShapeEvidence::Widened* top,
                              const CompletionConfig& config) {
  const double thickness_m = typical_thickness(seen, config);
  PartList list(seen, top ? top->top.center : seen.footprint().center);
  if (top) {
    list.begin();
    const double deep = seen.edge_of(top->top).value_or(thickness_m);
    list.add_alone(top->top.size.prod() * deep, top->top.center - 0.5 * deep * seen.up());
    list.end({top->top, deep});
  }
  // boards before their edges, so that an edge is part of its board
  std::vector<const Surface*> surfaces;
  for (const Surface& s : seen.surfaces()) surfaces.push_back(&s);
  std::stable_sort(surfaces.begin(), surfaces.end(),
                   [](const Surface* a, const Surface* b) { return narrow_side(*a) > narrow_side(*b); });
  for (const Surface* surface : surfaces) {
    const Surface& s = *surface;
    if (is_floor(s, seen) || (top && belongs_to(top->top, s, seen, config))) continue;
    if (const auto* r = std::get_if<Rectangle>(&s)) {
      const double above_m = seen.ground().height(r->center),
                   own_m = thickness_of(*r, seen, thickness_m, config);
      add_face(list, *r, r->normal.dot(seen.up()) > 0.9 ? std::min(own_m, above_m) : own_m);
    }
    if (const auto* c = std::get_if<Cylinder>(&s)) add_round(list, *c, thickness_m);
  }
  if (!top) add_rest(list, seen, thickness_m);

  double mass = 0.0, hidden = 0.0;
  Vec3 moment = Vec3::Zero();
  for (const Part& part : list.parts()) {
    mass += part.seen + part.hidden, hidden += part.hidden;
    moment += part.seen_moment + part.hidden_moment;
  }
  if (mass <= 0.0) return complete_mirrored(seen, config);
  CompletedShape s;
  s.kind = CompletedShape::Kind::Parts;
  s.box = seen.footprint();
  s.cog = moment / mass;
  const double end = seen.end_sigma(s.box.size.head<2>().maxCoeff()) + seen.depth_sigma_m();
  s.covariance = end * end * Eigen::Matrix3d::Identity();
  // without a top nobody knows what of it is hidden, cut by the view or lost on the ground
  if (!top) s.covariance += spread(s.box.axes, config.shape_sigma * s.box.size);
  for (const Part& part : list.parts()) {
    const Vec3 by_seen = config.part_sigma * (part.seen_moment - part.seen * s.cog) / mass;
    const Vec3 by_hidden = config.hidden_part_sigma * (part.hidden_moment - part.hidden * s.cog) / mass;
    s.covariance += by_seen * by_seen.transpose() + by_hidden * by_hidden.transpose();
  }
  s.reason = fmt::format(
      "{} parts between which the camera looks through, {:.0f} mm thick; {:.0f} % of the whole is taken "
      "to be on the hidden side, opposite of what is seen",
      list.parts().size(), 1e3 * thickness_m, 100.0 * hidden / mass);
  return s;
}

}  // namespace colift::perception
