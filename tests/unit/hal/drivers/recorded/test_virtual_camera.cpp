#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <map>
#include <random>
#include <tuple>

#include "hal/drivers/recorded/cloud_files/pcd.hpp"
#include "hal/drivers/recorded/frame_file.hpp"
#include "hal/drivers/recorded/virtual_camera.hpp"
#include "writers.hpp"

using namespace colift::hal;
using namespace colift::hal::test;

namespace {

PointFile list() {
  PointFile out;
  out.height = 1;
  return out;
}

void add(PointFile& points, const Vec3& p) {
  points.x.push_back(static_cast<float>(p.x()));
  points.y.push_back(static_cast<float>(p.y()));
  points.z.push_back(static_cast<float>(p.z()));
  points.width = static_cast<int>(points.size());
}

Vec3 point(const PointFile& points, std::size_t i) {
  return {points.x[i], points.y[i], points.z[i]};
}

PointFile laptop_points() {
  const auto bytes = load_file(data("real/02_laptop_and_box/source.pcd"));
  REQUIRE(bytes);
  const auto points = parse_pcd(*bytes, "source.pcd");
  REQUIRE(points);
  return *points;
}

// The seen points in another order, without the holes.
PointFile shuffled(const PointFile& points, std::uint32_t seed) {
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (points.seen(i)) order.push_back(i);
  }
  std::mt19937 random(seed);
  for (std::size_t i = order.size() - 1; i > 0; --i) std::swap(order[i], order[random() % (i + 1)]);
  PointFile out = list();
  for (const std::size_t i : order) add(out, point(points, i));
  return out;
}

Pose look_at(const Vec3& eye, const Vec3& target) {
  Pose X = Pose::Identity();
  X.linear().col(2) = (target - eye).normalized();
  X.linear().col(0) = X.linear().col(2).cross(Vec3::UnitZ()).normalized();
  X.linear().col(1) = X.linear().col(2).cross(X.linear().col(0));
  X.translation() = eye;
  return X;
}

// Median distance from the frame's points to the nearest of the file's, over some of them (m).
double median_distance(const PointFile& points, const VirtualView& view) {
  std::map<std::tuple<int, int, int>, std::vector<std::size_t>> cells;
  constexpr double kCell_m = 0.05;
  const auto cell = [&](const Vec3& p) {
    return std::tuple(static_cast<int>(std::floor(p.x() / kCell_m)),
                      static_cast<int>(std::floor(p.y() / kCell_m)),
                      static_cast<int>(std::floor(p.z() / kCell_m)));
  };
  for (std::size_t i = 0; i < points.size(); ++i) cells[cell(point(points, i))].push_back(i);
  const CameraIntrinsics& k = view.frame.intrinsics;
  std::vector<double> distances;
  const std::size_t step = view.frame.depth_m.size() / 2000 + 1;
  for (std::size_t i = 0; i < view.frame.depth_m.size(); i += step) {
    const double z = view.frame.depth_m[i];
    if (std::isnan(z)) continue;
    const double u = static_cast<double>(i % static_cast<std::size_t>(k.width)),
                 v = static_cast<double>(i / static_cast<std::size_t>(k.width));
    const Vec3 p = view.X_FC * Vec3((u - k.cx) / k.fx * z, (v - k.cy) / k.fy * z, z);
    double nearest = kCell_m;
    const auto [a, b, c] = cell(p);
    for (int da = -1; da <= 1; ++da) {
      for (int db = -1; db <= 1; ++db) {
        for (int dc = -1; dc <= 1; ++dc) {
          const auto found = cells.find({a + da, b + db, c + dc});
          if (found == cells.end()) continue;
          for (const std::size_t j : found->second)
            nearest = std::min(nearest, (point(points, j) - p).norm());
        }
      }
    }
    distances.push_back(nearest);
  }
  REQUIRE(distances.size() > 100);
  std::nth_element(distances.begin(), distances.begin() + static_cast<std::ptrdiff_t>(distances.size() / 2),
                   distances.end());
  return distances[distances.size() / 2];
}

// A floor, a table top above it and a box on the top, sampled evenly over their surfaces as a merged map has
// them.
PointFile room(std::uint32_t seed, double spacing_m) {
  std::mt19937 random(seed);
  const auto jitter = [&] { return spacing_m * (static_cast<double>(random()) / 4294967296.0 - 0.5); };
  PointFile out = list();
  const auto plate = [&](const Vec3& corner, const Vec3& u, const Vec3& v) {
    for (double a = 0.0; a < u.norm(); a += spacing_m) {
      for (double b = 0.0; b < v.norm(); b += spacing_m)
        add(out, corner + (a + jitter()) * u.normalized() + (b + jitter()) * v.normalized());
    }
  };
  plate({-1.5, -1.5, 0.0}, {3, 0, 0}, {0, 3, 0});
  plate({-0.4, -0.3, 0.7}, {0.8, 0, 0}, {0, 0.6, 0});
  plate({-0.1, -0.1, 0.9}, {0.2, 0, 0}, {0, 0.2, 0});
  plate({-0.1, -0.1, 0.7}, {0.2, 0, 0}, {0, 0, 0.2});
  return out;
}

}  // namespace

TEST_CASE("points without order go back into the pixels that they came from", "[virtual_camera][real]") {
  const PointFile organised = laptop_points();
  const auto view = view_points(shuffled(organised, 1), "list.pcd");
  REQUIRE(view);
  INFO(view->note);
  CHECK(view->X_FC.matrix().isIdentity(0.0));
  const CameraIntrinsics& k = view->frame.intrinsics;
  CHECK(std::abs(k.fx - 525.0) < 0.05);
  CHECK(std::abs(k.fy - 525.0) < 0.05);
  CHECK(view->visible == 1.0);
  // the picture is the old one without its empty border
  const int du = static_cast<int>(std::lround(320.0 - k.cx)),
            dv = static_cast<int>(std::lround(240.0 - k.cy));
  std::size_t same_pixels = 0, seen = 0;
  for (int v = 0; v < k.height; ++v) {
    for (int u = 0; u < k.width; ++u) {
      const float z = view->frame.depth_m[static_cast<std::size_t>(v * k.width + u)];
      const std::size_t old = static_cast<std::size_t>((v + dv) * 640 + u + du);
      seen += std::isnan(z) ? 0 : 1;
      same_pixels += !std::isnan(z) && z == organised.z[old] ? 1 : 0;
    }
  }
  CHECK(seen == 271575);
  CHECK(same_pixels == seen);
}

TEST_CASE("a thinned list of camera points still finds its pixel grid", "[virtual_camera][real]") {
  const PointFile all = shuffled(laptop_points(), 2);
  PointFile some = list();
  for (std::size_t i = 0; i < all.size(); i += 2) add(some, point(all, i));
  const auto view = view_points(some, "half.pcd");
  REQUIRE(view);
  INFO(view->note);
  CHECK(std::abs(view->frame.intrinsics.fx - 525.0) < 0.1);
}

TEST_CASE("a voxel filtered cloud becomes a closed depth image of the same surfaces",
          "[virtual_camera][real]") {
  const PointFile all = laptop_points();
  for (const double leaf_m : {0.003, 0.005, 0.01}) {
    std::map<std::tuple<int, int, int>, std::pair<Vec3, int>> leaves;
    for (std::size_t i = 0; i < all.size(); ++i) {
      if (!all.seen(i)) continue;
      const Vec3 p = point(all, i);
      auto& leaf = leaves
                       .try_emplace({static_cast<int>(std::floor(p.x() / leaf_m)),
                                     static_cast<int>(std::floor(p.y() / leaf_m)),
                                     static_cast<int>(std::floor(p.z() / leaf_m))},
                                    Vec3::Zero(), 0)
                       .first->second;
      leaf.first += p;
      ++leaf.second;
    }
    PointFile points = list();
    for (const auto& [key, leaf] : leaves) add(points, leaf.first / leaf.second);
    const auto view = view_points(points, "voxel.pcd");
    INFO((view ? view->note : view.error().text()));
    CAPTURE(leaf_m, points.size());
    REQUIRE(view);
    CAPTURE(view->visible);
    CHECK(view->visible > 0.8);
    CHECK(median_distance(points, *view) < 0.5 * leaf_m);
  }
}

TEST_CASE("points in a robot's frame are seen from the VIEWPOINT of the file", "[virtual_camera][real]") {
  PointFile points = shuffled(laptop_points(), 3);
  const Pose X_FC = look_at(Vec3(1.2, -0.5, 0.9), Vec3(0.2, 0.1, 0.0));
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vec3 p = X_FC * point(points, i);
    points.x[i] = static_cast<float>(p.x());
    points.y[i] = static_cast<float>(p.y());
    points.z[i] = static_cast<float>(p.z());
  }
  SECTION("with its orientation") {
    points.viewpoint = X_FC;
    const auto view = view_points(points, "robot.pcd");
    REQUIRE(view);
    INFO(view->note);
    CHECK((view->X_FC.inverse() * X_FC).matrix().isIdentity(1e-9));
    CHECK(std::abs(view->frame.intrinsics.fx - 525.0) < 0.1);
    CHECK(view->visible > 0.999);
  }
  SECTION("with its position only") {
    points.viewpoint.translation() = X_FC.translation();
    const auto view = view_points(points, "robot.pcd");
    REQUIRE(view);
    INFO(view->note);
    CHECK((view->X_FC.translation() - X_FC.translation()).norm() < 1e-9);
    CHECK(view->visible > 0.85);
    CHECK(median_distance(points, *view) < 2e-3);
  }
}

TEST_CASE("points in a body frame or a graphics frame go back into their pixels too",
          "[virtual_camera][real]") {
  const PointFile optical = shuffled(laptop_points(), 6);
  PointFile body = list(), graphics = list();
  for (std::size_t i = 0; i < optical.size(); ++i) {
    const Vec3 p = point(optical, i);
    add(body, Vec3(p.z(), -p.x(), -p.y()));
    add(graphics, Vec3(p.x(), -p.y(), -p.z()));
  }
  for (const PointFile& points : {body, graphics}) {
    const auto view = view_points(points, "axes.pcd");
    REQUIRE(view);
    INFO(view->note);
    CHECK(std::abs(view->frame.intrinsics.fx - 525.0) < 0.05);
    CHECK(view->visible == 1.0);
    CHECK(view->X_FC.linear().determinant() == Approx(1.0));
    CHECK(median_distance(points, *view) < 1e-4);
  }
}

TEST_CASE("a map of several views is refused in words", "[virtual_camera]") {
  // two floors of one house, each as dense as the other, seen from above
  PointFile points = list();
  std::mt19937 random(5);
  const auto unit = [&] { return static_cast<double>(random()) / 4294967296.0 - 0.5; };
  for (int i = 0; i < 60000; ++i) add(points, Vec3(2.0 * unit(), 2.0 * unit(), 2.0 + (i % 3) * 0.5));
  const auto view = view_points(points, "map.pcd");
  REQUIRE_FALSE(view);
  CHECK(view.error().code == ErrorCode::BadInput);
  INFO(view.error().text());
  CHECK(view.error().detail.find("map of several views") != std::string::npos);
}

TEST_CASE("points around the origin are refused in words", "[virtual_camera]") {
  PointFile points = room(1, 0.02);
  const auto view = view_points(points, "room.pcd");
  REQUIRE_FALSE(view);
  INFO(view.error().text());
  CHECK(view.error().detail.find("surround it") != std::string::npos);
}

TEST_CASE("one view of a sampled room is drawn when its camera is named", "[virtual_camera]") {
  PointFile points = room(1, 0.01);
  const Vec3 eye(2.4, -0.4, 1.6);
  // what this camera cannot see is not in its file
  PointFile seen = list();
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vec3 p = point(points, i);
    const double at_top = (eye.z() - 0.7) / (eye.z() - p.z());
    const Vec3 through = eye + at_top * (p - eye);
    const bool under = p.z() < 0.69 && std::abs(through.x()) < 0.4 && std::abs(through.y()) < 0.3;
    if (!under) add(seen, p);
  }
  seen.viewpoint.translation() = eye;
  const auto view = view_points(seen, "view.pcd");
  INFO((view ? view->note : view.error().text()));
  REQUIRE(view);
  CHECK(view->visible > 0.8);
  CHECK(median_distance(seen, *view) < 0.01);
}

TEST_CASE("points in one plane with the camera are refused in words", "[virtual_camera]") {
  PointFile points = list();
  for (int i = 0; i < 100; ++i) {
    for (int j = 0; j < 50; ++j) add(points, Vec3(0.01 * i - 0.5, 0.0, 1.0 + 0.01 * j));
  }
  const auto view = view_points(points, "plane.pcd");
  REQUIRE_FALSE(view);
  INFO(view.error().text());
  CHECK(view.error().detail.find("in one plane with it") != std::string::npos);
}

TEST_CASE("a handful of points is no image", "[virtual_camera]") {
  PointFile points = list();
  for (int i = 0; i < 50; ++i) add(points, Vec3(0.01 * i, 0.003 * i * i, 1.0));
  const auto view = view_points(points, "few.pcd");
  REQUIRE_FALSE(view);
  CHECK(view.error().text() ==
        "few.pcd: 50 finite points without image order are too few to make an image; expected at least 200");
}

TEST_CASE("the same points give the same picture, bit for bit", "[virtual_camera]") {
  const PointFile points = shuffled(laptop_points(), 4);
  PointFile noisy = points;
  for (std::size_t i = 0; i < noisy.size(); ++i) noisy.x[i] += 1e-3f * static_cast<float>(i % 7);
  const auto a = view_points(noisy, "a.pcd"), b = view_points(noisy, "a.pcd");
  REQUIRE(a);
  REQUIRE(b);
  CHECK(same(a->frame.depth_m, b->frame.depth_m));
  CHECK(a->frame.intrinsics.fx == b->frame.intrinsics.fx);
}
