#include "perception/thesis/thesis_surfaces.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numeric>

#include "perception/footprint.hpp"
#include "perception/thesis/plane_ransac.hpp"

namespace colift::perception {
namespace {

using Eigen::Vector2d;

/// Part of the rectangle's cells, nearly square and about cell_m wide, that hold a point.
double covered_part(std::span<const Vector2d> points, const FlatRectangle& rectangle, double cell_m) {
  const auto cells_along = [&](double length) {
    return static_cast<int>(std::clamp(std::round(length / cell_m), 1.0, 4096.0));
  };
  const int columns = cells_along(rectangle.size.x()), rows = cells_along(rectangle.size.y());
  const Vector2d u = rectangle.u, v = rectangle.v();
  const Vector2d corner = rectangle.center - 0.5 * rectangle.size.x() * u - 0.5 * rectangle.size.y() * v;
  std::vector<char> covered(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows), 0);
  for (const Vector2d& p : points) {
    const int column = static_cast<int>(u.dot(p - corner) / rectangle.size.x() * columns);
    const int row = static_cast<int>(v.dot(p - corner) / rectangle.size.y() * rows);
    covered[static_cast<std::size_t>(std::clamp(row, 0, rows - 1) * columns +
                                     std::clamp(column, 0, columns - 1))] = 1;
  }
  return static_cast<double>(std::accumulate(covered.begin(), covered.end(), 0)) /
         static_cast<double>(covered.size());
}

/// One plane of the object with its axes, and the rectangles that it was split into.
struct Face {
  Plane plane;
  Vec3 u, v;
  double cell_m;
  const ThesisConfig& config;
  std::vector<Rectangle>& out;

  void cover(std::span<Vector2d> points) {
    if (std::ssize(points) < config.surface_min_points) return;
    const FlatRectangle rectangle = minimum_area_rectangle(convex_hull(points));
    if (rectangle.size.y() < config.rectangle_min_size_m) return;

    const double fill = covered_part(points, rectangle, cell_m);
    if (fill >= config.rectangle_min_fill) {
      out.push_back(in_space(rectangle, fill));
      return;
    }
    // below two cells a half says nothing new about how well it is covered
    if (rectangle.size.x() < 2 * cell_m) return;
    const auto half = std::partition(points.begin(), points.end(), [&](const Vector2d& p) {
      return rectangle.u.dot(p - rectangle.center) < 0;
    });
    const auto first = static_cast<std::size_t>(half - points.begin());
    if (first == 0 || first == points.size()) return;
    cover(points.first(first));
    cover(points.subspan(first));
  }

  [[nodiscard]] Rectangle in_space(const FlatRectangle& flat, double fill) const {
    Rectangle rectangle;
    rectangle.center = u * flat.center.x() + v * flat.center.y() - plane.offset * plane.normal;
    rectangle.normal = plane.normal;
    rectangle.u = u * flat.u.x() + v * flat.u.y();
    rectangle.v = plane.normal.cross(rectangle.u);
    rectangle.size = flat.size;
    rectangle.fill = fill;
    return rectangle;
  }
};

}  // namespace

std::vector<Rectangle> thesis_surfaces(std::span<const Eigen::Vector3f> object, const Vec3& eye_W,
                                       const ThesisConfig& config) {
  const PclCloud cloud{object};
  const std::vector<Eigen::Vector3f> points = cloud.to_vector();
  std::vector<int> rest(points.size());
  std::iota(rest.begin(), rest.end(), 0);
  const auto few = static_cast<std::size_t>(std::max(
      config.surface_rest_fraction * static_cast<double>(points.size()), 1.0 * config.surface_min_points));

  std::vector<Rectangle> rectangles;
  while (rest.size() > few) {
    const auto fit =
        largest_plane(cloud, rest, {config.surface_distance_m, config.surface_iterations, config.seed});
    if (!fit || std::ssize(fit->inliers) < config.surface_min_points) break;

    Plane plane = fit->plane;
    if (plane.height(eye_W) < 0) plane = {-plane.normal, -plane.offset};
    const auto [u, v] = hal::tangents(plane.normal);
    std::vector<Vector2d> flat;
    flat.reserve(fit->inliers.size());
    for (const int i : fit->inliers) {
      const Vec3 p = points[static_cast<std::size_t>(i)].cast<double>();
      flat.emplace_back(u.dot(p), v.dot(p));
    }
    Face{plane, u, v, std::max(config.rectangle_cell_m, 2 * config.voxel_leaf_m), config, rectangles}.cover(
        flat);

    std::vector<int> remaining;
    remaining.reserve(rest.size() - fit->inliers.size());
    std::set_difference(rest.begin(), rest.end(), fit->inliers.begin(), fit->inliers.end(),
                        std::back_inserter(remaining));
    rest = std::move(remaining);
  }
  return rectangles;
}

}  // namespace colift::perception
