#include "perception/surfaces/cylinder_fit.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "hal/types/symmetric.hpp"
#include "hal/types/units.hpp"

namespace colift::perception {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;

// In standard deviations; beyond it a residual is no noise, and counts no more.
constexpr double kOutlier = 3.0;
constexpr double kMinSlant =
    0.35;  // a ray along the surface moves its point sideways, which costs something too

double capped(double residual) {
  return std::min(residual * residual, kOutlier * kOutlier);
}

/// Points seen along an axis.
struct FlatPoint {
  Vector2d p, ray;
  double sigma_m;
};

std::vector<FlatPoint> flatten(std::span<const SightedPoint> points, const Vec3& e1, const Vec3& e2,
                               const Vec3& origin, std::size_t most) {
  std::vector<FlatPoint> flat;
  const std::size_t step = std::max<std::size_t>(1, points.size() / most);
  flat.reserve(points.size() / step + 1);
  for (std::size_t i = 0; i < points.size(); i += step) {
    const SightedPoint& s = points[i];
    const Vec3 d = s.p - origin;
    flat.push_back({{e1.dot(d), e2.dot(d)}, {e1.dot(s.ray), e2.dot(s.ray)}, s.sigma_m});
  }
  return flat;
}

double sigma_along(const Vector2d& normal, const FlatPoint& f) {
  return f.sigma_m * std::max(std::abs(normal.dot(f.ray)), kMinSlant);
}

struct Circle {
  Vector2d center = Vector2d::Zero();
  double radius = 0;
};

double circle_cost(const Circle& c, const std::vector<FlatPoint>& points) {
  double sum = 0;
  for (const FlatPoint& f : points) {
    const Vector2d d = f.p - c.center;
    const double r = d.norm();
    if (r < 1e-9) {
      sum += kOutlier * kOutlier;
      continue;
    }
    sum += capped((r - c.radius) / sigma_along(d / r, f));
  }
  return sum / static_cast<double>(points.size());
}

// algebraic circle of weighted points: x^2 + y^2 + D x + E y + F = 0
bool algebraic_circle(const std::vector<FlatPoint>& points, const std::vector<double>& weight,
                      Circle& circle) {
  Matrix3d A = Matrix3d::Zero();
  Vec3 b = Vec3::Zero();
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vec3 row(points[i].p.x(), points[i].p.y(), 1.0);
    A += weight[i] * row * row.transpose();
    b -= weight[i] * points[i].p.squaredNorm() * row;
  }
  const Eigen::LDLT<Matrix3d> solver(A);
  if (solver.info() != Eigen::Success || !(solver.vectorD().minCoeff() > 1e-14)) return false;
  const Vec3 x = solver.solve(b);
  const double square = 0.25 * (x[0] * x[0] + x[1] * x[1]) - x[2];
  if (!(square > 0)) return false;
  circle = {{-0.5 * x[0], -0.5 * x[1]}, std::sqrt(square)};
  return true;
}

// noise makes the algebraic circle too small and flying points draw it aside: geometric steps follow,
// robustly
bool fit_circle(const std::vector<FlatPoint>& points, Circle& circle) {
  std::vector<double> weight(points.size(), 1.0);
  if (!algebraic_circle(points, weight, circle)) return false;
  for (int round = 0; round < 8; ++round) {
    Matrix3d H = Matrix3d::Zero();
    Vec3 g = Vec3::Zero();
    for (const FlatPoint& f : points) {
      const Vector2d d = f.p - circle.center;
      const double r = d.norm();
      if (r < 1e-9) continue;
      const Vector2d n = d / r;
      const double s = sigma_along(n, f), e = (r - circle.radius) / s;
      const double w = std::abs(e) > 2 ? 2 / std::abs(e) : 1.0;
      const Vec3 J(-n.x() / s, -n.y() / s, -1.0 / s);
      H += w * J * J.transpose();
      g += w * e * J;
    }
    H.diagonal() *= 1.0 + 1e-6;
    const Vec3 step = hal::solve_symmetric<double, 3>(H, -g);
    if (!step.allFinite()) return false;
    circle.center += step.head<2>();
    circle.radius += step[2];
    if (!(circle.radius > 0)) return false;
    if (step.norm() < 1e-5) break;
  }
  return true;
}

/// Mean cost of two perpendicular lines, whose outer sides the camera sees, or of one, over all directions. A
/// corner of a box or a leg looks so along its length.
double corner_cost(const std::vector<FlatPoint>& some, const std::vector<FlatPoint>& all) {
  constexpr int kDirections = 15;        // 6 degrees apart; the last line of this function looks between them
  constexpr double kStill_sigma = 0.02;  // a smaller correction ends the iteration
  double best = std::numeric_limits<double>::infinity();
  Vector2d rays = Vector2d::Zero();
  double mean_sigma = 0;
  for (const FlatPoint& f : some) rays += f.ray, mean_sigma += f.sigma_m / static_cast<double>(some.size());
  const auto cost_at = [&](double angle, const std::vector<FlatPoint>& points) {
    const Vector2d a(std::cos(angle), std::sin(angle)), b(-a.y(), a.x());
    // the visible sides face the rays
    const Vector2d na = a.dot(rays) < 0 ? a : Vector2d(-a), nb = b.dot(rays) < 0 ? b : Vector2d(-b);
    double da = -1e9, db = -1e9;
    for (const FlatPoint& f : points) da = std::max(da, na.dot(f.p)), db = std::max(db, nb.dot(f.p));
    // outermost points are noise: start a little inside
    da -= mean_sigma, db -= mean_sigma;
    double cost = 0;
    for (int round = 0; round < 5; ++round) {
      double sum_a = 0, weight_a = 0, sum_b = 0, weight_b = 0;
      cost = 0;
      for (const FlatPoint& f : points) {
        const double sa = sigma_along(na, f), sb = sigma_along(nb, f);
        const double xa = na.dot(f.p), xb = nb.dot(f.p);
        const double ra = (xa - da) / sa, rb = (xb - db) / sb;
        if (std::abs(ra) < std::abs(rb)) {
          const double w = (std::abs(ra) > 2 ? 2 / std::abs(ra) : 1.0) / (sa * sa);
          sum_a += w * xa, weight_a += w;
          cost += capped(ra);
        } else {
          const double w = (std::abs(rb) > 2 ? 2 / std::abs(rb) : 1.0) / (sb * sb);
          sum_b += w * xb, weight_b += w;
          cost += capped(rb);
        }
      }
      const double a_before = da, b_before = db;
      if (weight_a > 0) da = sum_a / weight_a;
      if (weight_b > 0) db = sum_b / weight_b;
      if (std::abs(da - a_before) + std::abs(db - b_before) < kStill_sigma * mean_sigma) break;
    }
    return cost / static_cast<double>(points.size());
  };
  double best_angle = 0;
  for (int k = 0; k < kDirections; ++k) {
    const double angle = 0.5 * std::numbers::pi * k / kDirections;
    const double cost = cost_at(angle, some);
    if (cost < best) best = cost, best_angle = angle;
  }
  best = std::numeric_limits<double>::infinity();
  for (const double turn : {0.0, -0.035, 0.035, -0.07, 0.07})
    best = std::min(best, cost_at(best_angle + turn, all));
  return best;
}

/// Residual of a point across the axis, and the mantle's outward normal there.
struct Observation {
  Vec3 normal;
  double residual_m, sigma_m;
};

Observation at_point(const Vec3& across, const Vec3& ray, double sigma_m, double radius) {
  const double r = std::max(across.norm(), 1e-9);
  const Vec3 normal = across / r;
  return {normal, r - radius, sigma_m * std::max(std::abs(normal.dot(ray)), kMinSlant)};
}

// Weight and normal where the ray meets the mantle. Where the point is, they would follow its noise: points
// of the flanks that lie too deep would weigh more than those that lie too near, and make a far, thin
// cylinder too thin by a sixth.
Observation at_ray(const Vec3& across, const Vec3& ray, double sigma_m, double radius) {
  constexpr double kGrazing = 0.94;  // of the radius; beyond, depth tells little
  const double length = ray.norm();
  if (length < 1e-9) return at_point(across, ray, sigma_m, radius);
  const Vec3 along = ray / length;
  const double depth = along.dot(across);
  const Vec3 beside = across - depth * along;
  const double half = std::sqrt(std::max(radius * radius - beside.squaredNorm(), 0.0)), slant = half / radius;
  if (beside.squaredNorm() > kGrazing * kGrazing * radius * radius)
    return at_point(across, ray, sigma_m, radius);
  return {(beside - half * along) / radius, -(depth + half) * slant,
          sigma_m * std::max(length * slant, kMinSlant)};
}

// Eight steps in (two offsets, two tilts, radius). `residual` is at_point or at_ray; residuals over `cut`
// count as outliers.
template <class Residual>
bool refine(std::span<const SightedPoint> points, Cylinder& c, const Residual& residual, double cut) {
  using Vector5 = Eigen::Matrix<double, 5, 1>;
  using Matrix5 = Eigen::Matrix<double, 5, 5>;
  for (int round = 0; round < 8; ++round) {
    const auto [e1, e2] = hal::tangents(c.axis);
    Matrix5 H = Matrix5::Zero();
    Vector5 g = Vector5::Zero();
    for (const SightedPoint& s : points) {
      const Vec3 d = s.p - c.center;
      const double along = c.axis.dot(d);
      const Vec3 across = d - along * c.axis, ray = s.ray - c.axis.dot(s.ray) * c.axis;
      const auto [n, off, sigma] = residual(across, ray, s.sigma_m, c.radius);
      const double e = off / sigma;
      const double w = std::abs(e) > 2 ? (std::abs(e) > cut ? 0.0 : 2 / std::abs(e)) : 1.0;
      const double n1 = n.dot(e1), n2 = n.dot(e2);
      Vector5 J;
      J << -n1, -n2, -n1 * along, -n2 * along, -1.0;
      J /= sigma;
      for (int i = 0; i < 5; ++i)
        for (int k = 0; k <= i; ++k) H(i, k) += w * J[i] * J[k];
      g += w * e * J;
    }
    H.diagonal() *= 1.0 + 1e-6;
    const Vector5 step = hal::solve_symmetric<double, 5>(H, -g);
    if (!step.allFinite()) return false;
    c.center += step[0] * e1 + step[1] * e2;
    c.axis = (c.axis + step[2] * e1 + step[3] * e2).normalized();
    c.radius += step[4];
    if (!(c.radius > 0)) return false;
    if (step.cwiseAbs().maxCoeff() < 1e-5) break;
  }
  return true;
}

double covered_arc(const std::vector<FlatPoint>& points, const Circle& circle) {
  // angles relative to the direction of the mean point, which is far from the cut at 180 degrees
  Vector2d mean = Vector2d::Zero();
  for (const FlatPoint& f : points) mean += f.p - circle.center;
  std::vector<double> angle;
  for (const FlatPoint& f : points) {
    const Vector2d d = f.p - circle.center;
    angle.push_back(std::atan2(mean.x() * d.y() - mean.y() * d.x(), mean.dot(d)));
  }
  const auto at = [&](double part) {
    const auto k = angle.begin() + static_cast<std::ptrdiff_t>(part * static_cast<double>(angle.size() - 1));
    std::nth_element(angle.begin(), k, angle.end());
    return *k;
  };
  return at(0.98) - at(0.02);
}

}  // namespace

MantleDistance distance_to(const Cylinder& c, const SightedPoint& s) {
  const Vec3 d = s.p - c.center;
  const Vec3 across = d - c.axis.dot(d) * c.axis;
  const double r = across.norm();
  const double slant = r > 1e-9 ? std::abs(across.dot(s.ray)) / r : 1.0;
  return {r - c.radius, s.sigma_m * std::max(slant, kMinSlant)};
}

std::optional<CylinderFit> fit_cylinder(std::span<const SightedPoint> points, std::span<const Vec3> axes,
                                        const Vec3& eye, const SurfaceConfig& config) {
  if (points.size() < static_cast<std::size_t>(config.min_pixels)) return std::nullopt;
  Vec3 mean = Vec3::Zero();
  for (const SightedPoint& s : points) mean += s.p;
  mean /= static_cast<double>(points.size());

  std::optional<Cylinder> best;
  double best_cost = std::numeric_limits<double>::infinity();
  for (const Vec3& axis : axes) {
    const auto [e1, e2] = hal::tangents(axis);
    const std::vector<FlatPoint> flat =
        flatten(points, e1, e2, mean, static_cast<std::size_t>(config.cylinders.quick_points));
    Circle circle;
    if (!fit_circle(flat, circle)) continue;
    if (circle.radius < 0.5 * config.cylinder_min_radius_m ||
        circle.radius > 1.5 * config.cylinder_max_radius_m)
      continue;
    const double cost = circle_cost(circle, flat);
    if (cost < best_cost) {
      best_cost = cost;
      best = Cylinder{mean + circle.center.x() * e1 + circle.center.y() * e2, axis, circle.radius, 0.0};
    }
  }
  // far off already: the last steps would not make a cylinder of it
  if (!best || best_cost > 1.6 * config.cylinder_max_misfit * config.cylinder_max_misfit) return std::nullopt;
  if (!refine(points, *best, at_point, 6.0)) return std::nullopt;
  if (best->radius < config.cylinder_min_radius_m || best->radius > config.cylinder_max_radius_m)
    return std::nullopt;
  // the camera sees the outside: a hollow seen from within is none
  if ((mean - best->center).dot(eye - mean) < 0) {
    const Vec3 d = mean - best->center;
    if ((d - best->axis.dot(d) * best->axis).dot(eye - mean) < 0) return std::nullopt;
  }

  CylinderFit fit;
  fit.cylinder = *best;
  const auto [e1, e2] = hal::tangents(best->axis);
  const std::vector<FlatPoint> flat =
      flatten(points, e1, e2, best->center, 2 * static_cast<std::size_t>(config.cylinders.judge_points));
  const Circle circle{Vector2d::Zero(), best->radius};
  fit.misfit = std::sqrt(circle_cost(circle, flat));
  fit.arc_rad = covered_arc(flat, circle);
  if (fit.misfit > config.cylinder_max_misfit || fit.arc_rad < hal::deg_to_rad(config.cylinder_min_arc_deg))
    return std::nullopt;
  return fit;
}

Cylinder without_bias(std::span<const SightedPoint> points, const Cylinder& biased,
                      const SurfaceConfig& config) {
  // Residuals in standard deviations that count as outliers; corrections, in units of the expected bias, that
  // points of something else must have caused.
  constexpr double kCut = 4.0, kMostBias = 3.0;
  std::vector<SightedPoint> near;
  double square = 0;
  for (const SightedPoint& s : points) {
    const MantleDistance d = distance_to(biased, s);
    if (std::abs(d.value_m) > kOutlier * d.sigma_m + config.tolerance_m) continue;
    near.push_back(s);
    square += s.sigma_m * s.sigma_m;
  }
  Cylinder c = biased;
  if (near.size() < static_cast<std::size_t>(config.min_pixels) || !refine(near, c, at_ray, kCut))
    return biased;
  // a larger change comes from points that lie on something else
  const double bias = square / static_cast<double>(near.size()) / biased.radius;
  const bool allowed = std::abs(c.radius - biased.radius) < kMostBias * bias + config.tolerance_m &&
                       c.radius > config.cylinder_min_radius_m && c.radius < config.cylinder_max_radius_m;
  return allowed ? c : biased;
}

double corner_misfit(std::span<const SightedPoint> points, const Cylinder& cylinder,
                     const CylinderSearchConfig& config) {
  const auto [e1, e2] = hal::tangents(cylinder.axis);
  return std::sqrt(corner_cost(
      flatten(points, e1, e2, cylinder.center, static_cast<std::size_t>(config.quick_points)),
      flatten(points, e1, e2, cylinder.center, 2 * static_cast<std::size_t>(config.judge_points))));
}

}  // namespace colift::perception
