#include "perception/footprint.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <limits>

using colift::hal::OrientedBox;
using colift::hal::Plane;
using colift::perception::box_on_plane;
using colift::perception::BoxTrim;
using colift::perception::convex_hull;
using colift::perception::FlatRectangle;
using colift::perception::minimum_area_rectangle;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Points = std::vector<Vector2d>;

namespace {

/// Uniform numbers that are the same on every machine.
class Dice {
 public:
  explicit Dice(std::uint64_t seed) : state_(seed * 0x9E3779B97F4A7C15ull + 1) {}
  double operator()(double low, double high) {
    state_ = state_ * 6364136223846793005ull + 1442695040888963407ull;
    return low + (high - low) * static_cast<double>(state_ >> 11) * 0x1p-53;
  }

 private:
  std::uint64_t state_;
};

double cross(const Vector2d& a, const Vector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

/// A point is a corner when some pair (it, q) has every other point strictly to the left or on the segment's
/// line between them: the hull's definition, tried for all pairs.
Points hull_by_all_pairs(const Points& points) {
  Points corners;
  for (const Vector2d& a : points) {
    bool corner = false;
    for (const Vector2d& b : points) {
      if (a == b) continue;
      bool edge = true;
      for (const Vector2d& p : points) {
        const double side = cross(b - a, p - a);
        const double along = (p - a).dot(b - a);
        edge = edge && (side > 0 || (side == 0 && along >= 0 && along <= (b - a).squaredNorm()));
      }
      corner = corner || edge;
    }
    if (corner) corners.push_back(a);
  }
  return corners;
}

double min_area_by_turning(const Points& points) {
  double best = std::numeric_limits<double>::infinity();
  for (const Vector2d& a : points)
    for (const Vector2d& b : points) {
      if (a == b) continue;
      const Vector2d u = (b - a).normalized(), v{-u.y(), u.x()};
      double ul = 1e300, uh = -1e300, vl = 1e300, vh = -1e300;
      for (const Vector2d& p : points) {
        ul = std::min(ul, u.dot(p)), uh = std::max(uh, u.dot(p));
        vl = std::min(vl, v.dot(p)), vh = std::max(vh, v.dot(p));
      }
      best = std::min(best, (uh - ul) * (vh - vl));
    }
  return best;
}

}  // namespace

TEST_CASE("the hull has the corners that the definition gives", "[footprint]") {
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    Dice dice(seed);
    Points points;
    // small integers: many equal points and many on one line, and exact arithmetic
    for (int i = 0; i < 3 + static_cast<int>(seed); ++i)
      points.emplace_back(std::floor(dice(0, 7)), std::floor(dice(-3, 6)));

    const Points hull = convex_hull(points);
    Points expected = hull_by_all_pairs(points);
    const auto before = [](const Vector2d& a, const Vector2d& b) {
      return a.x() < b.x() || (a.x() == b.x() && a.y() < b.y());
    };
    std::sort(expected.begin(), expected.end(), before);
    expected.erase(std::unique(expected.begin(), expected.end()), expected.end());
    Points found = hull;
    std::sort(found.begin(), found.end(), before);

    REQUIRE(found == expected);
    for (std::size_t i = 0; i < hull.size() && hull.size() > 2; ++i)
      CHECK(cross(hull[(i + 1) % hull.size()] - hull[i], hull[(i + 2) % hull.size()] - hull[i]) > 0);
  }
}

TEST_CASE("no point of a dense cloud lies outside its hull", "[footprint]") {
  Dice dice(5);
  Points points;
  for (int i = 0; i < 5000; ++i) {
    const double angle = dice(0, 6.2831853), radius = std::sqrt(dice(0, 1));
    points.emplace_back(1000 + radius * std::cos(angle), 0.3 * radius * std::sin(angle));
  }
  const Points hull = convex_hull(points);

  REQUIRE(hull.size() > 20);
  double worst = std::numeric_limits<double>::infinity();
  for (const Vector2d& p : points)
    for (std::size_t i = 0; i < hull.size(); ++i)
      worst = std::min(worst, cross(hull[(i + 1) % hull.size()] - hull[i], p - hull[i]));
  CHECK(worst > -1e-9);
}

TEST_CASE("the rectangle is as small as trying every direction makes it, and holds every point",
          "[footprint]") {
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    Dice dice(seed + 1000);
    Points points;
    for (int i = 0; i < 3 + static_cast<int>(seed % 30); ++i) points.emplace_back(dice(-2, 2), dice(0, 0.7));
    const FlatRectangle r = minimum_area_rectangle(convex_hull(points));

    CHECK(r.area() == Approx(min_area_by_turning(convex_hull(points))).epsilon(1e-9));
    CHECK(r.size.x() >= r.size.y());
    CHECK(r.u.norm() == Approx(1));
    for (const Vector2d& p : points) {
      CHECK(std::abs(r.u.dot(p - r.center)) <= r.size.x() / 2 + 1e-9);
      CHECK(std::abs(r.v().dot(p - r.center)) <= r.size.y() / 2 + 1e-9);
    }
  }
}

TEST_CASE("points without an area still have a rectangle", "[footprint]") {
  CHECK(convex_hull(Points{}).empty());
  CHECK(std::isnan(minimum_area_rectangle(Points{}).center.x()));

  const Points same(9, Vector2d{0.2, -0.1});
  CHECK(convex_hull(same).size() == 1);
  CHECK(minimum_area_rectangle(convex_hull(same)).center == same[0]);
  CHECK(minimum_area_rectangle(convex_hull(same)).size == Vector2d::Zero());

  Points line;
  for (int i = 0; i < 100; ++i) line.emplace_back(i, 2 * i);
  const FlatRectangle r = minimum_area_rectangle(convex_hull(line));
  CHECK(convex_hull(line).size() == 2);
  CHECK(r.size.x() == Approx(99 * std::sqrt(5.0)));
  CHECK(r.size.y() == Approx(0).margin(1e-9));
  CHECK(r.center.isApprox(Vector2d{49.5, 99}, 1e-9));
}

namespace {

/// Points on the walls of an upright box that stands 10 cm above a tilted plane.
struct BoxOnPlane {
  Plane ground{Vector3d{0.1, -0.8, -0.6}.normalized(), 0.75};
  Vector3d u = Vector3d{1, 0.2, 0}.cross(ground.normal).normalized();
  Vector3d v = ground.normal.cross(u);
  Vector3d size{0.6, 0.25, 0.4};
  Vector3d center = -0.75 * ground.normal + 0.3 * ground.normal + 0.2 * u + 0.1 * v;
  std::vector<Eigen::Vector3f> points;

  BoxOnPlane() {
    Dice dice(3);
    for (int i = 0; i < 20000; ++i) {
      Vector3d p{dice(-0.5, 0.5), dice(-0.5, 0.5), dice(-0.5, 0.5)};
      p(i % 3) = i % 2 ? 0.5 : -0.5;
      p = p.cwiseProduct(size);
      points.push_back((center + u * p.x() + v * p.y() + ground.normal * p.z()).cast<float>());
    }
  }
};

double angle_of_lines_deg(const Vector3d& a, const Vector3d& b) {
  return std::atan2(a.cross(b).norm(), std::abs(a.dot(b))) * 180 / M_PI;
}

}  // namespace

TEST_CASE("a box on a tilted plane is found with its size, place and direction", "[footprint]") {
  const BoxOnPlane truth;
  const OrientedBox box = box_on_plane(truth.points, truth.ground);

  CHECK((box.size - truth.size).cwiseAbs().maxCoeff() < 1e-3);
  CHECK((box.center - truth.center).norm() < 1e-3);
  CHECK(angle_of_lines_deg(box.axes.col(0), truth.u) < 0.1);
  CHECK(box.axes.col(2).isApprox(truth.ground.normal, 1e-12));
  CHECK(box.axes.determinant() == Approx(1));
  CHECK(std::isnan(box_on_plane({}, truth.ground).center.x()));
}

TEST_CASE("a few strays stretch the plain box but not the trimmed one", "[footprint]") {
  BoxOnPlane truth;
  for (int i = 0; i < 40; ++i)  // 0.2 % of the points, each alone in its cell
    truth.points.push_back(
        (truth.center + truth.u * (0.4 + 0.01 * i) + truth.ground.normal * (0.3 + 0.01 * i)).cast<float>());

  CHECK(box_on_plane(truth.points, truth.ground).size.x() > 1.0);
  const OrientedBox box = box_on_plane(truth.points, truth.ground, BoxTrim{});
  CHECK((box.size - truth.size).cwiseAbs().maxCoeff() < 0.01);
  CHECK((box.center - truth.center).norm() < 0.01);
}

TEST_CASE("trimming a cloud of one point per cell leaves its footprint whole", "[footprint]") {
  std::vector<Eigen::Vector3f> points;
  for (int i = 0; i < 30; ++i)
    for (int j = 0; j < 10; ++j)
      points.emplace_back(0.01f * static_cast<float>(i), 0.01f * static_cast<float>(j), 0.5f);
  const OrientedBox box = box_on_plane(points, Plane{}, BoxTrim{});
  CHECK(box.size.x() == Approx(0.29).margin(1e-4));
  CHECK(box.size.y() == Approx(0.09).margin(1e-4));
  CHECK(box.size.z() == Approx(0).margin(1e-6));
}
