#include "perception/footprint.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <tuple>

namespace colift::perception {

using Eigen::Vector2d;
using Eigen::Vector3d;

namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr int kMaxCells = 4096;  // per side of the footprint

double cross(const Vector2d& a, const Vector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}
double turn(const Vector2d& a, const Vector2d& b, const Vector2d& c) {
  return cross(b - a, c - a);
}

bool before(const Vector2d& a, const Vector2d& b) {
  return a.x() < b.x() || (a.x() == b.x() && a.y() < b.y());
}

/// Points that can be corners of the hull: those not well inside the octagon of the extremes in eight
/// directions.
std::vector<Vector2d> outer_points(std::span<const Vector2d> points) {
  constexpr std::size_t kSmall = 64;
  if (points.size() < kSmall) return {points.begin(), points.end()};

  // x, x + y, y, y - x and their opposites, in counter-clockwise order
  std::array<double, 8> best;
  best.fill(-std::numeric_limits<double>::infinity());
  std::array<Vector2d, 8> corner;
  for (const Vector2d& p : points) {
    const double diagonal = p.x() + p.y(), across = p.y() - p.x();
    const std::array<double, 8> reach{p.x(), diagonal, p.y(), across, -p.x(), -diagonal, -p.y(), -across};
    for (std::size_t k = 0; k < 8; ++k)
      if (reach[k] > best[k]) {
        best[k] = reach[k];
        corner[k] = p;
      }
  }

  // each edge as a x + b y < c for the points inside, with a margin far above rounding and far below any
  // effect
  const double span = std::max(best[0] + best[4], best[2] + best[6]);
  const double margin = 1e-9 * span;
  std::array<double, 8> a{}, b{}, c{};
  std::size_t edges = 0;
  for (std::size_t k = 0; k < 8; ++k) {
    const Vector2d edge = corner[(k + 1) % 8] - corner[k];
    const double length = edge.norm();
    if (length <= margin) continue;
    a[edges] = edge.y() / length;
    b[edges] = -edge.x() / length;
    c[edges] = a[edges] * corner[k].x() + b[edges] * corner[k].y() - margin;
    ++edges;
  }

  std::vector<Vector2d> outer;
  for (const Vector2d& p : points) {
    bool inside = true;
    for (std::size_t k = 0; k < edges && inside; ++k) inside = a[k] * p.x() + b[k] * p.y() < c[k];
    if (!inside || edges == 0) outer.push_back(p);
  }
  return outer;
}

/// Points of a plane's cells that hold enough of them.
std::vector<Vector2d> without_sparse_cells(const std::vector<Vector2d>& flat, const BoxTrim& trim) {
  Vector2d low = flat.front(), high = flat.front();
  for (const Vector2d& p : flat) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  const double cell_m = std::max(trim.cell_m, (high - low).maxCoeff() / (kMaxCells - 2));
  // cells keep their place in the plane when the object's extent changes by a stray
  const double u0 = std::floor(low.x() / cell_m), v0 = std::floor(low.y() / cell_m);
  const auto columns = static_cast<std::size_t>(std::floor(high.x() / cell_m) - u0) + 1;
  const auto rows = static_cast<std::size_t>(std::floor(high.y() / cell_m) - v0) + 1;

  std::vector<std::uint32_t> cell_of(flat.size());
  std::vector<int> count(columns * rows, 0);
  for (std::size_t i = 0; i < flat.size(); ++i) {
    const auto column = static_cast<std::size_t>(std::floor(flat[i].x() / cell_m) - u0);
    const auto row = static_cast<std::size_t>(std::floor(flat[i].y() / cell_m) - v0);
    cell_of[i] = static_cast<std::uint32_t>(row * columns + column);
    ++count[cell_of[i]];
  }
  std::vector<Vector2d> kept;
  kept.reserve(flat.size());
  for (std::size_t i = 0; i < flat.size(); ++i)
    if (count[cell_of[i]] >= trim.cell_points) kept.push_back(flat[i]);
  return kept;
}

/// Points as coordinates along two axes of the plane, and their heights above it.
struct Flattened {
  Vector3d u, v;
  std::vector<Vector2d> flat;
  std::vector<double> height;
};

Flattened flatten(std::span<const Eigen::Vector3f> points, const hal::Plane& ground) {
  Flattened out;
  std::tie(out.u, out.v) = hal::tangents(ground.normal);
  out.flat.reserve(points.size());
  out.height.reserve(points.size());
  for (const Eigen::Vector3f& point : points) {
    const Vector3d p = point.cast<double>();
    out.flat.emplace_back(out.u.dot(p), out.v.dot(p));
    out.height.push_back(ground.height(p));
  }
  return out;
}

hal::OrientedBox upright_box(const Flattened& points, const std::vector<Vector2d>& footprint, double low,
                             double high, const hal::Plane& ground) {
  const FlatRectangle base = minimum_area_rectangle(convex_hull(footprint));
  hal::OrientedBox box;
  box.axes.col(0) = points.u * base.u.x() + points.v * base.u.y();
  box.axes.col(2) = ground.normal;
  box.axes.col(1) = ground.normal.cross(box.axes.col(0));
  box.size = {base.size.x(), base.size.y(), high - low};
  box.center = points.u * base.center.x() + points.v * base.center.y() +
               ground.normal * (0.5 * (low + high) - ground.offset);
  return box;
}

// one point for each cell that points lie in: a footprint counts by its area, not by how well it was seen
std::vector<Vector2d> occupied_cells(const std::vector<Vector2d>& points, double cell_m) {
  std::vector<std::pair<std::int32_t, std::int32_t>> cells;
  cells.reserve(points.size());
  for (const Vector2d& p : points)
    cells.emplace_back(static_cast<std::int32_t>(std::floor(p.x() / cell_m)), static_cast<std::int32_t>(std::floor(p.y() / cell_m)));
  std::sort(cells.begin(), cells.end());
  cells.erase(std::unique(cells.begin(), cells.end()), cells.end());
  std::vector<Vector2d> centers;
  centers.reserve(cells.size());
  for (const auto& [i, k] : cells) centers.emplace_back((i + 0.5) * cell_m, (k + 0.5) * cell_m);
  return centers;
}

// draws the sides of a box in over tips that are a small part of its footprint
void trim_sides(hal::OrientedBox& box, const Flattened& frame, const std::vector<Vector2d>& points, const BoxTrim& trim) {
  const std::vector<Vector2d> cells = occupied_cells(points, trim.cell_m);
  const auto skip = static_cast<std::ptrdiff_t>(trim.side_cells * static_cast<double>(cells.size()));
  if (skip < 1) return;
  const double slack = trim.cell_m * std::numbers::sqrt2 / 2;
  for (int k = 0; k < 2; ++k) {
    const hal::Vec3 axis = box.axes.col(k);
    const Vector2d flat(frame.u.dot(axis), frame.v.dot(axis));
    std::vector<double> along;
    along.reserve(cells.size());
    for (const Vector2d& c : cells) along.push_back(flat.dot(c));
    std::nth_element(along.begin(), along.begin() + skip, along.end());
    const double from = along[static_cast<std::size_t>(skip)] - slack;
    const auto last = std::ssize(along) - 1 - skip;
    std::nth_element(along.begin(), along.begin() + last, along.end());
    const double to = along[static_cast<std::size_t>(last)] + slack;
    const double middle = axis.dot(box.center);
    const double low = std::max(from, middle - 0.5 * box.size[k]), high = std::min(to, middle + 0.5 * box.size[k]);
    box.center += (0.5 * (low + high) - middle) * axis;
    box.size[k] = high - low;
  }
  if (box.size.x() >= box.size.y()) return;
  // the longer side leads
  box.axes.col(0).swap(box.axes.col(1));
  box.axes.col(1) = -box.axes.col(1);
  std::swap(box.size.x(), box.size.y());
}

hal::OrientedBox no_box() {
  hal::OrientedBox box;
  box.center.setConstant(kNaN);
  return box;
}

}  // namespace

std::vector<Vector2d> convex_hull(std::span<const Vector2d> points) {
  if (points.empty()) return {};
  std::vector<Vector2d> sorted = outer_points(points);
  std::sort(sorted.begin(), sorted.end(), before);
  sorted.erase(std::unique(sorted.begin(), sorted.end()), sorted.end());
  if (sorted.size() < 3) return sorted;

  std::vector<Vector2d> hull(2 * sorted.size());
  std::size_t n = 0;
  const auto add = [&](const Vector2d& p, std::size_t fixed) {
    while (n >= fixed + 2 && turn(hull[n - 2], hull[n - 1], p) <= 0) --n;
    hull[n++] = p;
  };
  for (const Vector2d& p : sorted) add(p, 0);
  const std::size_t lower = n - 1;
  for (auto p = sorted.rbegin() + 1; p != sorted.rend(); ++p) add(*p, lower);
  hull.resize(n - 1);  // the last corner is the first again
  return hull;
}

FlatRectangle minimum_area_rectangle(std::span<const Vector2d> hull) {
  const std::size_t n = hull.size();
  FlatRectangle best;
  if (n == 0) {
    best.center.setConstant(kNaN);
    return best;
  }
  double best_area = std::numeric_limits<double>::infinity();
  best.center = hull[0];
  std::size_t right = 0, top = 0, left = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const Vector2d edge = hull[(i + 1) % n] - hull[i];
    const double length = edge.norm();
    if (length == 0) continue;
    const Vector2d u = edge / length, v{-u.y(), u.x()};
    // the three other contacts only ever move forward, because the hull turns one way
    const auto advance = [&](std::size_t& at, std::size_t from, const Vector2d& direction) {
      at = std::max(at, from);
      while (at < from + n && direction.dot(hull[(at + 1) % n]) > direction.dot(hull[at % n])) ++at;
    };
    advance(right, i + 1, u);
    advance(top, right, v);
    advance(left, top, -u);

    const double u_low = u.dot(hull[left % n]), u_high = u.dot(hull[right % n]);
    const double v_low = v.dot(hull[i]), v_high = v.dot(hull[top % n]);
    const double area = (u_high - u_low) * (v_high - v_low);
    if (area >= best_area) continue;
    best_area = area;
    best.center = 0.5 * (u_low + u_high) * u + 0.5 * (v_low + v_high) * v;
    best.u = u;
    best.size = {u_high - u_low, v_high - v_low};
  }
  if (best.size.x() < best.size.y()) {
    best.u = best.v();
    std::swap(best.size.x(), best.size.y());
  }
  if (best.u.x() < 0 || (best.u.x() == 0 && best.u.y() < 0)) best.u = -best.u;
  return best;
}

hal::OrientedBox box_on_plane(std::span<const Eigen::Vector3f> points, const hal::Plane& ground) {
  if (points.empty()) return no_box();
  const Flattened all = flatten(points, ground);
  const auto [low, high] = std::minmax_element(all.height.begin(), all.height.end());
  return upright_box(all, all.flat, *low, *high, ground);
}

hal::OrientedBox box_on_plane(std::span<const Eigen::Vector3f> points, const hal::Plane& ground,
                              const BoxTrim& trim) {
  if (points.empty()) return no_box();
  Flattened all = flatten(points, ground);
  const std::vector<Vector2d> dense = without_sparse_cells(all.flat, trim);

  const auto skip = static_cast<std::ptrdiff_t>(trim.quantile * static_cast<double>(points.size()));
  const auto at_low = all.height.begin() + std::min(skip, std::ssize(all.height) - 1);
  std::nth_element(all.height.begin(), at_low, all.height.end());
  const double low = *at_low;
  const auto at_high = all.height.begin() + std::max<std::ptrdiff_t>(std::ssize(all.height) - 1 - skip, 0);
  std::nth_element(all.height.begin(), at_high, all.height.end());
  const double high = std::max(low, *at_high);
  const bool too_thin = 2 * dense.size() < all.flat.size();
  const std::vector<Vector2d>& kept = too_thin ? all.flat : dense;
  hal::OrientedBox box = upright_box(all, kept, low, high, ground);
  if (!too_thin) trim_sides(box, all, kept, trim);
  return box;
}

}  // namespace colift::perception
