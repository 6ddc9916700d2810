#include "planner/grasp/round_plate.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

namespace colift::planner {
namespace {

using perception::Rectangle;

constexpr int kDirections = 24;           // in which the rim of a round plate is searched
constexpr double kCorner = 0.47;          // of a rectangle's sides: there it has corners
constexpr std::size_t kLeastPoints = 20;  // of the plate in each
constexpr double kRim = 0.98;             // quantile of their distances that is the rim
constexpr std::size_t kLeastRims = 12;    // directions in which it has to be seen ...
constexpr double kMaxHidden_rad = 2.0;    // ... and between two of them
constexpr double kMaxUneven_m = 0.006;    // deviation from the circle, beside the noise

// x^2 + y^2 = 2 a x + 2 b y + c (Kasa 1976)
std::pair<Eigen::Vector2d, double> circle_through(const std::vector<Eigen::Vector2d>& points) {
  Eigen::MatrixX3d A(static_cast<Eigen::Index>(points.size()), 3);
  Eigen::VectorXd squares(A.rows());
  for (Eigen::Index i = 0; i < A.rows(); ++i) {
    const Eigen::Vector2d& p = points[static_cast<std::size_t>(i)];
    A.row(i) << 2.0 * p.x(), 2.0 * p.y(), 1.0;
    squares[i] = p.squaredNorm();
  }
  const Eigen::Vector3d c = A.colPivHouseholderQr().solve(squares);
  return {c.head<2>(), std::sqrt(std::max(0.0, c.z() + c.head<2>().squaredNorm()))};
}

double widest_gap(const std::vector<Eigen::Vector2d>& around) {
  std::vector<double> angles;
  for (const Eigen::Vector2d& p : around) angles.push_back(std::atan2(p.y(), p.x()));
  std::sort(angles.begin(), angles.end());
  double widest = angles.front() + 2.0 * std::numbers::pi - angles.back();
  for (std::size_t i = 1; i < angles.size(); ++i) widest = std::max(widest, angles[i] - angles[i - 1]);
  return widest;
}

// How far a plate goes in each direction from the middle of its rectangle (m, along u and v): by the points
// that were measured, because the projector's shadow beside it passes for a part of it.
std::vector<Eigen::Vector2d> rims_around(const Rectangle& plate, const Obstacles& obstacles,
                                         const SeenSpace& seen) {
  const double noise = 0.004 + 3.0 * seen.sigma(plate.center), reach = plate.size.maxCoeff();
  hal::Aabb around;
  for (const double u : {-reach, reach})
    for (const double v : {-reach, reach})
      for (const double n : {-noise, noise})
        around.extend(plate.center + u * plate.u + v * plate.v + n * plate.normal);
  std::vector<std::vector<double>> radii(kDirections);
  obstacles.for_each_bucket(around, [&](const Obstacles::Bucket& bucket) {
    for (std::uint32_t i = bucket.begin; i < bucket.end; ++i) {
      if (obstacles.kind(i) != ObstacleKind::Object) continue;
      const Vec3 d = obstacles.points()[i].cast<double>() - plate.center;
      if (std::abs(d.dot(plate.normal)) > noise) continue;
      const double u = d.dot(plate.u), v = d.dot(plate.v);
      const double turn = std::atan2(v, u) / (2.0 * std::numbers::pi) + 1.0;
      radii[static_cast<std::size_t>(turn * kDirections + 0.5) % kDirections].push_back(std::hypot(u, v));
    }
  });
  std::vector<Eigen::Vector2d> rims;
  for (int k = 0; k < kDirections; ++k) {
    std::vector<double>& r = radii[static_cast<std::size_t>(k)];
    if (r.size() < kLeastPoints) continue;
    const auto rim = r.begin() + static_cast<std::ptrdiff_t>(kRim * static_cast<double>(r.size()));
    std::nth_element(r.begin(), rim, r.end());
    const double angle = 2.0 * std::numbers::pi * k / kDirections;
    rims.push_back(*rim * Eigen::Vector2d(std::cos(angle), std::sin(angle)));
  }
  return rims;
}

// Whether a plate fills its rectangle into most of its corners: it is not round. The projector's shadow may
// fill two.
bool has_corners(const Rectangle& plate, const SeenSpace& seen) {
  int filled = 0;
  for (const double u : {-kCorner, kCorner})
    for (const double v : {-kCorner, kCorner})
      filled += seen.at(plate.center + u * plate.size.x() * plate.u + v * plate.size.y() * plate.v) ==
                Sight::Surface;
  return filled > 2;
}

}  // namespace

std::optional<RoundPlate> find_round_plate(const Rectangle& plate, const Obstacles& obstacles,
                                           const SeenSpace& seen) {
  if (has_corners(plate, seen)) return std::nullopt;
  std::vector<Eigen::Vector2d> rims = rims_around(plate, obstacles, seen);
  const double tolerance = kMaxUneven_m + seen.sigma(plate.center);
  const std::size_t least = std::max<std::size_t>(kLeastRims, rims.size() - rims.size() / 4);
  while (rims.size() >= least && widest_gap(rims) <= kMaxHidden_rad) {
    const auto [middle, radius] = circle_through(rims);
    const auto off = [m = middle, r = radius](const Eigen::Vector2d& p) {
      return std::abs((p - m).norm() - r);
    };
    const auto worst = std::max_element(rims.begin(), rims.end(),
                                        [&](const auto& a, const auto& b) { return off(a) < off(b); });
    if (off(*worst) <= tolerance)
      return RoundPlate{plate.center + middle.x() * plate.u + middle.y() * plate.v, radius};
    rims.erase(worst);
  }
  return std::nullopt;
}

}  // namespace colift::planner
