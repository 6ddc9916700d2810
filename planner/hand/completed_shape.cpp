#include "planner/hand/completed_shape.hpp"

#include <algorithm>
#include <cmath>

namespace colift::planner {
namespace {

using perception::Rectangle;

constexpr double kMinBoard_m = 0.1;  // wide and below the plate: rungs are thinner

/// Whether the camera looked through more than a part of a box.
bool is_free(const hal::OrientedBox& box, const SeenSpace& seen, double max_free, int n) {
  const double most = max_free * (n * n * n);
  int free = 0;
  for (int k = 0; k < n; ++k) {
    for (int j = 0; j < n; ++j) {
      for (int i = 0; i < n; ++i) {
        const Vec3 f((i + 0.5) / n - 0.5, (j + 0.5) / n - 0.5, (k + 0.5) / n - 0.5);
        if (seen.at(box.center + box.axes * f.cwiseProduct(box.size)) == Sight::Free && ++free > most)
          return true;
      }
    }
  }
  return false;
}

/// Whether a narrow face below a plate carries boards under it, as the side of a shelf does and no leg.
bool carries_boards(const Rectangle& face, const Rectangle& plate, const perception::Scene& scene,
                    double tolerance_m, const SolidConfig& config) {
  const Vec3& up = plate.normal;
  return std::any_of(scene.surfaces.begin(), scene.surfaces.end(), [&](const perception::Surface& s) {
    const auto* board = std::get_if<Rectangle>(&s);
    if (board == nullptr || std::abs(board->normal.dot(up)) < config.perpendicular_cosine) return false;
    if (board->size.minCoeff() < kMinBoard_m) return false;
    const double level = up.dot(board->center);
    if (level > up.dot(plate.center) - kMinBoard_m) return false;
    const Vec3 at_board = face.center + (level - up.dot(face.center)) * up;
    return distance_to(*board, at_board) < 2.0 * tolerance_m;
  });
}

constexpr double kSlender = 3.0;  // a leg is longer than wide, at least by this

/// Whether a solid is a leg of a plate: slender, upright, under it.
bool is_leg_of(const Rectangle& plate, const hal::OrientedBox& box, const SolidConfig& config) {
  int axis = 0;
  const double length = box.size.maxCoeff(&axis);
  const Vec3 direction = box.axes.col(axis);
  Vec3 others = box.size;
  others[axis] = 0.0;
  if (length < kSlender * others.maxCoeff()) return false;
  if (std::abs(direction.dot(plate.normal)) < config.perpendicular_cosine) return false;
  const Vec3 d = box.center - plate.center;
  return plate.normal.dot(d) < -0.25 * length && std::abs(d.dot(plate.u)) < 0.5 * plate.size.x() &&
         std::abs(d.dot(plate.v)) < 0.5 * plate.size.y();
}

/// The other legs of a plate: tables and chairs have them at all corners, and the plate hides some of them
/// from most places. At the mirrored place of a leg that was seen one was seen, too, or the camera looked
/// through it.
void add_hidden_legs(const perception::Scene& scene, const SeenSpace& seen, double max_free,
                     const SolidConfig& config, CompletedSolids& solids) {
  const CompletedSolids found = solids;
  for (const perception::Surface& surface : scene.surfaces) {
    const auto* plate = std::get_if<Rectangle>(&surface);
    if (plate == nullptr) continue;
    for (const CompletedSolid& leg : found) {
      if (!is_leg_of(*plate, leg.box, config)) continue;
      const Vec3 d = leg.box.center - plate->center;
      const Vec3 across_u = 2.0 * d.dot(plate->u) * plate->u, across_v = 2.0 * d.dot(plate->v) * plate->v;
      for (const Vec3& mirrored : {across_u, across_v, Vec3(across_u + across_v)}) {
        CompletedSolid hidden{-1, -1, leg.box};
        hidden.box.center -= mirrored;
        const bool stands_there = std::any_of(solids.begin(), solids.end(), [&](const CompletedSolid& s) {
          return is_leg_of(*plate, s.box, config) &&
                 (s.box.center - hidden.box.center).norm() < 0.5 * leg.box.size.norm();
        });
        if (stands_there || is_free(hidden.box, seen, max_free, config.samples_per_side)) continue;
        solids.push_back(hidden);
      }
    }
  }
}

}  // namespace

std::vector<RectangleEdge> edges_of(const Rectangle& r) {
  const Vec3 u = 0.5 * r.size.x() * r.u, v = 0.5 * r.size.y() * r.v;
  return {{r.u, r.center + u - v, r.center + u + v},
          {-r.u, r.center - u - v, r.center - u + v},
          {r.v, r.center + v - u, r.center + v + u},
          {-r.v, r.center - v - u, r.center - v + u}};
}

double distance_to(const Rectangle& r, const Vec3& p) {
  const Vec3 d = p - r.center;
  const double u = std::clamp(d.dot(r.u), -0.5 * r.size.x(), 0.5 * r.size.x());
  const double v = std::clamp(d.dot(r.v), -0.5 * r.size.y(), 0.5 * r.size.y());
  return (d - u * r.u - v * r.v).norm();
}

bool faces_out(const RectangleEdge& edge_of_a, const Rectangle& b, const SolidConfig& config) {
  return b.normal.dot(edge_of_a.outward) > config.perpendicular_cosine;
}

double CompletedSolid::extent_along(const Vec3& direction) const {
  int axis = 0;
  (box.axes.transpose() * direction).cwiseAbs().maxCoeff(&axis);
  return box.size[axis];
}

CompletedSolids complete_solids(const perception::Scene& scene, const SeenSpace* seen, double tolerance_m,
                                double max_free, const SolidConfig& config) {
  CompletedSolids solids;
  for (std::size_t i = 0; i < scene.surfaces.size(); ++i) {
    const auto* a = std::get_if<Rectangle>(&scene.surfaces[i]);
    if (a == nullptr) continue;
    const std::vector<RectangleEdge> edges = edges_of(*a);
    for (std::size_t j = 0; j < scene.surfaces.size(); ++j) {
      const auto* b = std::get_if<Rectangle>(&scene.surfaces[j]);
      if (b == nullptr || j == i) continue;
      if (std::none_of(edges.begin(), edges.end(),
                       [&](const auto& edge) { return faces_out(edge, *b, config); })) {
        continue;
      }
      const auto same_pair = [&](const CompletedSolid& s) {
        return s.a == static_cast<int>(j) && s.b == static_cast<int>(i);
      };
      if (std::any_of(solids.begin(), solids.end(), same_pair)) continue;
      for (const RectangleEdge& edge : edges) {
        if (!faces_out(edge, *b, config) || a->normal.dot(b->center - a->center) > 0.0) continue;
        // the other face has to meet this edge somewhere, and lie on the inner side of this one
        bool meets = false;
        for (int k = 0; k <= 20 && !meets; ++k) {
          meets = distance_to(*b, edge.from + (edge.to - edge.from) * (k / 20.0)) < tolerance_m;
        }
        if (!meets) continue;

        const Vec3 n = a->normal, along = n.cross(b->normal).normalized(), m = along.cross(n);
        const Extent ea = extent_of(*a, along), eb = extent_of(*b, along);
        const double low = std::max(ea.low, eb.low), high = std::min(ea.high, eb.high);
        Extent in_n{extent_of(*b, n).low, n.dot(a->center)}, in_m{extent_of(*a, m).low, m.dot(b->center)};
        // a leg is about as thick as it is wide; the side of a shelf is as deep as its boards
        const auto is_leg = [&](const Rectangle& face, const Rectangle& plate) {
          return seen != nullptr && is_leg_face(face, plate, *seen, config.leg) &&
                 !carries_boards(face, plate, scene, tolerance_m, config);
        };
        if (is_leg(*b, *a)) in_m.low = std::max(in_m.low, in_m.high - eb.length());
        if (is_leg(*a, *b)) in_n.low = std::max(in_n.low, in_n.high - ea.length());
        const Vec3 size(high - low, in_m.high - in_m.low, in_n.high - in_n.low);
        if (size.minCoeff() <= 0.0) continue;
        CompletedSolid solid{static_cast<int>(i), static_cast<int>(j), {}};
        solid.box.axes << along, m, n;
        if (solid.box.axes.determinant() < 0.0) solid.box.axes.col(0) *= -1.0;
        solid.box.size = size;
        solid.box.center =
            0.5 * ((low + high) * along + (in_m.low + in_m.high) * m + (in_n.low + in_n.high) * n);
        if (seen != nullptr && is_free(solid.box, *seen, max_free, config.samples_per_side)) continue;
        solids.push_back(solid);
      }
    }
  }
  if (seen != nullptr) add_hidden_legs(scene, *seen, max_free, config, solids);
  return solids;
}

}  // namespace colift::planner
