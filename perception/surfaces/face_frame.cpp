#include "perception/surfaces/face_frame.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "perception/footprint.hpp"

namespace colift::perception {
namespace {

using Eigen::Vector2d;

double quantile(std::vector<double>& values, double part) {
  const auto at =
      values.begin() + static_cast<std::ptrdiff_t>(part * static_cast<double>(values.size() - 1) + 0.5);
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

/// What lies outermost on one side of a frame, in lines across one axis.
struct Side {
  std::vector<double> along, across;  // across grows outwards
  std::size_t sure = 0;               // the first so many are known ends

  /// Lines that run out into nothing do not tell, as long as there are others.
  [[nodiscard]] std::size_t telling() const { return 5 * sure >= across.size() ? sure : across.size(); }
};

std::array<Side, 2> outermost(const FaceFrame& f, const std::vector<FacePoint>& points, bool along_u,
                              double pixel_m) {
  const Vector2d a = along_u ? f.u : f.v(), c = along_u ? f.v() : f.u;
  const double first = along_u ? f.low_u : f.low_v, length = along_u ? f.width() : f.height();
  constexpr int kMostBins = 400;  // room for the lines across a side of 600 pixels
  const int bins = std::clamp(static_cast<int>(length / (1.5 * pixel_m)), 4, kMostBins);
  const double scale = bins / length;
  constexpr double kNone = -std::numeric_limits<double>::infinity();
  struct End {
    double across = kNone;
    bool sure = false;
  };
  std::array<std::array<End, kMostBins>, 2> ends;
  for (auto& e : ends) std::fill(e.begin(), e.begin() + bins, End{});
  for (const FacePoint& p : points) {
    const double s = static_cast<double>(p.s), t = static_cast<double>(p.t);
    const auto k = static_cast<std::size_t>(
        std::clamp(static_cast<int>((a.x() * s + a.y() * t - first) * scale), 0, bins - 1));
    const double across = c.x() * s + c.y() * t;
    if (-across > ends[0][k].across) ends[0][k] = {-across, p.sure};
    if (across > ends[1][k].across) ends[1][k] = {across, p.sure};
  }
  std::array<Side, 2> sides;
  // the ends of a side are rounded by its neighbours
  const int margin = bins / 12;
  for (std::size_t end = 0; end < 2; ++end) {
    sides[end].along.reserve(static_cast<std::size_t>(bins));
    sides[end].across.reserve(static_cast<std::size_t>(bins));
    for (const bool sure : {true, false}) {
      for (int k = margin; k < bins - margin; ++k) {
        const End& e = ends[end][static_cast<std::size_t>(k)];
        if (e.across == kNone || e.sure != sure) continue;
        sides[end].along.push_back(first + (k + 0.5) / scale);
        sides[end].across.push_back(e.across);
      }
      if (sure) sides[end].sure = sides[end].along.size();
    }
  }
  return sides;
}

/// Where a side is. Without lines that are known to end, most fall short.
double place(Side& side) {
  if (5 * side.sure >= side.across.size() && side.sure >= 4) {
    side.across.resize(side.sure);
    return quantile(side.across, 0.5);
  }
  return quantile(side.across, 0.75);
}

/// Slope of a side as the median over pairs of lines half of its length apart; robust against corners and
/// notches.
double slope(const Side& side) {
  const std::size_t half = side.telling() / 2;
  if (half < 4) return 0.0;
  std::vector<double> slopes(half);
  for (std::size_t i = 0; i < half; ++i)
    slopes[i] = (side.across[i + half] - side.across[i]) / (side.along[i + half] - side.along[i]);
  return quantile(slopes, 0.5);
}

FaceFrame frame_along(const Vector2d& u, const std::vector<Vector2d>& hull) {
  FaceFrame f{u, 0, 0, 0, 0};
  const Vector2d v = f.v();
  f.low_u = f.low_v = std::numeric_limits<double>::infinity();
  f.high_u = f.high_v = -f.low_u;
  for (const Vector2d& p : hull) {
    f.low_u = std::min(f.low_u, u.dot(p)), f.high_u = std::max(f.high_u, u.dot(p));
    f.low_v = std::min(f.low_v, v.dot(p)), f.high_v = std::max(f.high_v, v.dot(p));
  }
  return f;
}

/// How many of the points lie at the sides of a frame around them.
std::size_t at_sides(const FaceFrame& f, const std::vector<FacePoint>& points, double within_m) {
  const auto near = static_cast<float>(within_m);
  const auto ux = static_cast<float>(f.u.x()), uy = static_cast<float>(f.u.y());
  const auto low_u = static_cast<float>(f.low_u) + near, high_u = static_cast<float>(f.high_u) - near,
             low_v = static_cast<float>(f.low_v) + near, high_v = static_cast<float>(f.high_v) - near;
  std::size_t count = 0;
  for (const FacePoint& p : points) {
    const float a = ux * p.s + uy * p.t, b = ux * p.t - uy * p.s;
    count += (a < low_u) | (a > high_u) | (b < low_v) | (b > high_v);
  }
  return count;
}

/// The frame of least area, or one of hardly more that runs along the face's sides where that one does not:
/// around an L, such as the edge of a seat with a leg, a frame along the hypotenuse is as small as the one
/// along its arms.
FaceFrame along_sides(const std::vector<Vector2d>& hull, const std::vector<FacePoint>& points,
                      double pixel_m) {
  // Ratio of areas, and of points at the sides. These choose between two frames around the same points:
  // limits that depend on neither camera nor object.
  constexpr double kHardlyMore = 1.15, kClearly = 1.5;
  constexpr double kOtherDirection = 0.17;  // sine; a smaller turn is what trimmed() finds
  const FlatRectangle least = minimum_area_rectangle(hull);
  const FaceFrame first = frame_along(least.u, hull);
  FaceFrame best = first;
  std::size_t most = 0;
  for (std::size_t i = 0; i < hull.size(); ++i) {
    const Vector2d edge = hull[(i + 1) % hull.size()] - hull[i];
    if (edge.norm() < 4.0 * pixel_m) continue;  // a corner cut off
    const Vector2d u = edge.normalized();
    const double cosine = std::abs(u.dot(least.u)), sine = std::abs(u.dot(least.v()));
    if (std::min(cosine, sine) < kOtherDirection) continue;
    const FaceFrame other = frame_along(u, hull);
    if (other.width() * other.height() > kHardlyMore * least.area()) continue;
    if (most == 0)
      most = static_cast<std::size_t>(kClearly * static_cast<double>(at_sides(first, points, 1.5 * pixel_m)));
    const std::size_t count = at_sides(other, points, 1.5 * pixel_m);
    if (count > most) most = count, best = other;
  }
  return best;
}

}  // namespace

FaceFrame bounding_frame(const std::vector<FacePoint>& points, double pixel_m) {
  // of every row across, only the outermost points can be corners of the hull
  float low = std::numeric_limits<float>::max(), high = -low;
  for (const FacePoint& p : points) low = std::min(low, p.t), high = std::max(high, p.t);
  constexpr std::size_t kRows = 256;  // of the 480 rows of an image at most two fall into one
  const float scale = static_cast<float>(kRows - 1) / std::max(high - low, 1e-6f);
  std::array<const FacePoint*, kRows> left{}, right{};
  for (const FacePoint& p : points) {
    const auto r = static_cast<std::size_t>((p.t - low) * scale);
    if (!left[r] || p.s < left[r]->s) left[r] = &p;
    if (!right[r] || p.s > right[r]->s) right[r] = &p;
  }
  std::vector<Vector2d> ends;
  ends.reserve(2 * kRows);
  for (const auto* list : {&left, &right})
    for (const FacePoint* p : *list)
      if (p) ends.emplace_back(static_cast<double>(p->s), static_cast<double>(p->t));
  return along_sides(convex_hull(ends), points, pixel_m);
}

FaceFrame trimmed(const FaceFrame& outer, const std::vector<FacePoint>& points, const PixelStep& step) {
  constexpr double kMostTurn = 0.12;  // rad: a larger slope is a corner or a notch, not a crooked frame
  const double pixel_m = step.longest();
  FaceFrame f = outer;
  // sides turn the rectangle by how long they are: a corner that sticks out decides where the hull's edge
  // lies
  double turn = 0, weight = 0;
  for (const bool along_u : {true, false}) {
    const double length = along_u ? outer.width() : outer.height();
    const double other = along_u ? outer.height() : outer.width();
    if (length < 0.3 * other) continue;
    const auto sides = outermost(outer, points, along_u, pixel_m);
    for (std::size_t end = 0; end < 2; ++end) {
      // v grows to the left of u, u to the right of v
      const double m = slope(sides[end]) * (end == 0 ? -1 : 1) * (along_u ? 1 : -1);
      if (std::abs(m) > kMostTurn) continue;
      turn += m * length * length;
      weight += length * length;
    }
  }
  if (weight > 0) turn /= weight;
  f.u = Vector2d(outer.u.x() - turn * outer.u.y(), outer.u.y() + turn * outer.u.x()).normalized();
  f.low_u = f.low_v = std::numeric_limits<double>::infinity();
  f.high_u = f.high_v = -f.low_u;
  const Vector2d v = f.v();
  for (const FacePoint& p : points) {
    const double s = static_cast<double>(p.s), t = static_cast<double>(p.t);
    const double a = f.u.x() * s + f.u.y() * t, b = v.x() * s + v.y() * t;
    f.low_u = std::min(f.low_u, a), f.high_u = std::max(f.high_u, a);
    f.low_v = std::min(f.low_v, b), f.high_v = std::max(f.high_v, b);
  }
  auto across_u = outermost(f, points, true, pixel_m), across_v = outermost(f, points, false, pixel_m);
  if (across_u[0].across.empty() || across_v[0].across.empty()) return f;
  // a pixel's value stands for its middle
  const auto half = [&](const Vector2d& e) {
    return 0.5 * std::max(std::abs(e.dot(step.along_row)), std::abs(e.dot(step.along_column)));
  };
  f.low_v = -place(across_u[0]) - half(v), f.high_v = place(across_u[1]) + half(v);
  f.low_u = -place(across_v[0]) - half(f.u), f.high_u = place(across_v[1]) + half(f.u);
  return f;
}

}  // namespace colift::perception
