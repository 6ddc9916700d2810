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
constexpr int kMaxCells = 4096;  // per side of the footprint: bounds memory

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
  constexpr std::size_t kSmall = 64;  // fewer points cost less than the search for the octagon
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

// std::floor is a library call on plain x86-64
std::int64_t floor_of(double x) {
  const auto whole = static_cast<std::int64_t>(x);
  return whole - (x < static_cast<double>(whole) ? 1 : 0);
}

/// Square cells of a plane, and how many points lie in each.
class CellGrid {
 public:
  CellGrid(const std::vector<Vector2d>& points, const BoxTrim& trim) : dense_(trim.cell_points) {
    Vector2d low = points.front(), high = points.front();
    for (const Vector2d& p : points) {
      low = low.cwiseMin(p);
      high = high.cwiseMax(p);
    }
    cell_m_ = std::max(trim.cell_m, (high - low).maxCoeff() / (kMaxCells - 2));
    const double per_m = 1.0 / cell_m_;
    // cells keep their place in the plane when the object's extent changes by a stray
    u0_ = floor_of(low.x() * per_m);
    v0_ = floor_of(low.y() * per_m);
    columns_ = static_cast<std::size_t>(floor_of(high.x() * per_m) - u0_) + 1;
    rows_ = static_cast<std::size_t>(floor_of(high.y() * per_m) - v0_) + 1;
    count_.assign(columns_ * rows_, 0);
    cell_of_.resize(points.size());
    for (std::size_t i = 0; i < points.size(); ++i) {
      const auto column = static_cast<std::size_t>(floor_of(points[i].x() * per_m) - u0_);
      const auto row = static_cast<std::size_t>(floor_of(points[i].y() * per_m) - v0_);
      cell_of_[i] = static_cast<std::uint32_t>(row * columns_ + column);
      ++count_[cell_of_[i]];
    }
  }

  [[nodiscard]] double cell_m() const { return cell_m_; }

  /// Points in dense cells.
  [[nodiscard]] std::size_t dense_points() const {
    std::size_t n = 0;
    for (const int c : count_) n += c >= dense_ ? static_cast<std::size_t>(c) : 0;
    return n;
  }

  /// Middles of the dense cells.
  [[nodiscard]] std::vector<Vector2d> dense_cells() const {
    std::vector<Vector2d> centers;
    for (std::size_t row = 0; row < rows_; ++row)
      for (std::size_t column = 0; column < columns_; ++column)
        if (count_[row * columns_ + column] >= dense_)
          centers.emplace_back((static_cast<double>(u0_ + static_cast<std::int64_t>(column)) + 0.5) * cell_m_,
                               (static_cast<double>(v0_ + static_cast<std::int64_t>(row)) + 0.5) * cell_m_);
    return centers;
  }

  /// Points in dense cells that can be corners of their hull. With a point in each of the four quadrants
  /// around it a point is inside, and for whole cells that takes no more than the first and the last dense
  /// cell of each row.
  [[nodiscard]] std::vector<Vector2d> outer_points(const std::vector<Vector2d>& points) const {
    const auto columns = static_cast<std::int64_t>(columns_);
    std::vector<std::int64_t> first(rows_, columns), last(rows_, -1);
    for (std::size_t row = 0; row < rows_; ++row) {
      for (std::size_t column = 0; column < columns_; ++column) {
        if (count_[row * columns_ + column] < dense_) continue;
        first[row] = std::min(first[row], static_cast<std::int64_t>(column));
        last[row] = static_cast<std::int64_t>(column);
      }
    }
    // strictly between these columns a cell has dense ones on both sides, in rows below and in rows above
    std::vector<std::int64_t> from(rows_), to(rows_);
    std::int64_t least = columns, most = -1;
    for (std::size_t row = 0; row < rows_; ++row) {
      from[row] = least;
      to[row] = most;
      least = std::min(least, first[row]);
      most = std::max(most, last[row]);
    }
    least = columns;
    most = -1;
    for (std::size_t row = rows_; row-- > 0;) {
      from[row] = std::max(from[row], least);
      to[row] = std::min(to[row], most);
      least = std::min(least, first[row]);
      most = std::max(most, last[row]);
    }
    std::vector<std::uint8_t> wanted(count_.size());
    for (std::size_t row = 0; row < rows_; ++row) {
      for (std::size_t column = 0; column < columns_; ++column) {
        const auto c = static_cast<std::int64_t>(column);
        const bool inside = c > from[row] && c < to[row];
        wanted[row * columns_ + column] = !inside && count_[row * columns_ + column] >= dense_ ? 1 : 0;
      }
    }
    std::vector<Vector2d> outer;
    for (std::size_t i = 0; i < points.size(); ++i)
      if (wanted[cell_of_[i]]) outer.push_back(points[i]);
    return outer;
  }

 private:
  int dense_;
  double cell_m_ = 0.0;
  std::int64_t u0_ = 0, v0_ = 0;
  std::size_t columns_ = 0, rows_ = 0;
  std::vector<int> count_;
  std::vector<std::uint32_t> cell_of_;
};

/// Order statistics of numbers: sorted into bins once, then only one bin has to be looked into.
class Ranking {
 public:
  explicit Ranking(const std::vector<double>& values) : values_(values) {
    const auto [low, high] = std::minmax_element(values.begin(), values.end());
    low_ = *low;
    scale_ = *high > *low ? (kBins - 1) / (*high - *low) : 0.0;
    for (const double v : values) ++count_[bin(v)];
  }

  /// The value that stands at place k of the sorted ones.
  [[nodiscard]] double at(std::size_t k) const {
    std::size_t b = 0;
    for (; k >= count_[b]; ++b) k -= count_[b];
    std::vector<double> in_bin;
    in_bin.reserve(count_[b]);
    for (const double v : values_)
      if (bin(v) == b) in_bin.push_back(v);
    std::nth_element(in_bin.begin(), in_bin.begin() + static_cast<std::ptrdiff_t>(k), in_bin.end());
    return in_bin[k];
  }

 private:
  static constexpr std::size_t kBins = 256;
  [[nodiscard]] std::size_t bin(double v) const {
    return std::min(kBins - 1, static_cast<std::size_t>(static_cast<std::int64_t>((v - low_) * scale_)));
  }
  const std::vector<double>& values_;
  double low_ = 0.0, scale_ = 0.0;
  std::array<std::size_t, kBins> count_{};
};

/// Points as coordinates along two axes of the plane, and their heights above it.
struct Flattened {
  Vector3d u, v;
  std::vector<Vector2d> flat;
  std::vector<double> height;
};

Flattened flatten(std::span<const Eigen::Vector3f> points, const hal::Plane& ground) {
  Flattened out;
  std::tie(out.u, out.v) = hal::tangents(ground.normal);
  out.flat.resize(points.size());
  out.height.resize(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vector3d p = points[i].cast<double>();
    out.flat[i] = {out.u.dot(p), out.v.dot(p)};
    out.height[i] = ground.height(p);
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

// draws the sides of a box in over tips that are a small part of its footprint
void trim_sides(hal::OrientedBox& box, const Flattened& frame, const CellGrid& grid, const BoxTrim& trim) {
  // a footprint counts by its area, not by how well it was seen
  const std::vector<Vector2d> cells = grid.dense_cells();
  const auto skip = static_cast<std::ptrdiff_t>(trim.side_cells * static_cast<double>(cells.size()));
  if (skip < 1) return;
  const double slack = grid.cell_m() * std::numbers::sqrt2 / 2;
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
    const double low = std::max(from, middle - 0.5 * box.size[k]),
                 high = std::min(to, middle + 0.5 * box.size[k]);
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
  const Flattened all = flatten(points, ground);
  const CellGrid grid(all.flat, trim);
  const std::size_t last = points.size() - 1;
  const std::size_t skip =
      std::min(last, static_cast<std::size_t>(trim.quantile * static_cast<double>(points.size())));
  const Ranking heights(all.height);
  const double low = heights.at(skip), high = std::max(low, heights.at(last - skip));
  const bool too_thin = 2 * grid.dense_points() < points.size();
  hal::OrientedBox box =
      upright_box(all, too_thin ? all.flat : grid.outer_points(all.flat), low, high, ground);
  if (!too_thin) trim_sides(box, all, grid, trim);
  return box;
}

}  // namespace colift::perception
