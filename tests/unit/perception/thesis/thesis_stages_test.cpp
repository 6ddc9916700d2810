#include "perception/thesis/thesis_stages.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "perception/thesis/plane_ransac.hpp"
#include "sampled_shapes.hpp"

using namespace colift::perception;
using colift::test::SampledShapes;

namespace {

bool same_bits(const PlaneFit& a, const PlaneFit& b) {
  return a.plane.normal == b.plane.normal && a.plane.offset == b.plane.offset && a.inliers == b.inliers &&
         a.rms_m == b.rms_m;
}

/// A floor of 2 x 2 m with a box of 0.4 x 0.3 x 0.5 m on it and a smaller one beside.
std::vector<Eigen::Vector3f> floor_with_boxes() {
  return SampledShapes(0.01)
      .rectangle({-1, -1, 0}, {2, 0, 0}, {0, 2, 0})
      .box({-0.2, -0.1, 0}, {0.4, 0.3, 0.5})
      .box({0.6, 0.5, 0}, {0.1, 0.1, 0.2})
      .points;
}

}  // namespace

TEST_CASE("the same seed finds the same plane bit for bit, and the seed does reach PCL's generator",
          "[thesis]") {
  const PclCloud cloud{floor_with_boxes()};
  const PlaneSearch search{.distance_m = 0.01, .iterations = 20, .seed = 7};
  const auto first = largest_plane(cloud, search);
  const auto second = largest_plane(cloud, search);
  REQUIRE(first);
  REQUIRE(second);
  CHECK(same_bits(*first, *second));

  bool varies = false;  // with one trial the answer depends on the samples alone
  for (int seed = 0; seed < 10 && !varies; ++seed) {
    const auto a = largest_plane(cloud, {0.01, 1, seed});
    const auto b = largest_plane(cloud, {0.01, 1, seed + 1});
    REQUIRE(a);
    REQUIRE(b);
    varies = !same_bits(*a, *b);
  }
  CHECK(varies);
}

TEST_CASE("points on a line, three points and no points span no plane", "[thesis]") {
  CHECK_FALSE(largest_plane(PclCloud{}, PlaneSearch{}));
  CHECK_FALSE(
      largest_plane(PclCloud{SampledShapes(1, 0).rectangle({0, 0, 0}, {1, 0, 0}, {0, 0.1, 0}).points}, {}));
  std::vector<Eigen::Vector3f> line;
  for (int i = 0; i < 500; ++i) line.emplace_back(0.01f * static_cast<float>(i), 0.0f, 1.0f);
  CHECK_FALSE(largest_plane(PclCloud{line}, PlaneSearch{}));
}

TEST_CASE("the ground's normal looks at the eye, and what is under the ground is no object", "[thesis]") {
  std::vector<Eigen::Vector3f> points = floor_with_boxes();
  const std::size_t mirrored = 200;
  for (std::size_t i = 0; i < mirrored; ++i) points.emplace_back(0.001f * static_cast<float>(i), 0.0f, -0.4f);

  for (const double side : {1.0, -1.0}) {
    const auto split = split_at_ground(PclCloud{points}, Vec3{1, 1, 2 * side}, ThesisConfig{});
    REQUIRE(split);
    CHECK(split->ground.plane.normal.z() * side > 0.9999);
    CHECK(std::abs(split->ground.plane.offset) < 0.003);
    CHECK(split->ground.rms_m < 0.003);
    if (side < 0) CHECK(split->above.size() == mirrored);
  }
}

TEST_CASE("the depth limits are along the viewing axis and pixels without depth are no points", "[thesis]") {
  OrganisedCloud frame;
  const float nan = std::numeric_limits<float>::quiet_NaN();
  frame.depth_m = {0.2f, 0.3f, 3.5f, 3.6f, nan};
  frame.x = frame.y = {5, 5, 5, 5, nan};
  frame.z = {0.2f, 0.3f, 3.5f, 3.6f, nan};
  ThesisConfig config;
  CHECK(points_in_depth_range(frame, config).size() == 2);

  config.crop_max_m = {4.9, 10, 10};
  CHECK(pass_through(points_in_depth_range(frame, config), config).size() == 0);
  config.crop_max_m = {5.1, 10, 1};
  CHECK(pass_through(points_in_depth_range(frame, config), config).size() == 1);
}

TEST_CASE("a voxel is the mean of its points, however wide the cloud is", "[thesis]") {
  ThesisConfig config;
  config.voxel_leaf_m = 0.002;
  // 16 m along each axis in 2 mm steps are 5e11 voxels, beyond PCL's int
  std::vector<Eigen::Vector3f> points;
  for (const float x : {-8.0f, 8.0f})
    for (const float y : {-8.0f, 8.0f})
      for (const float z : {0.0f, 16.0f})
        for (const float step : {0.0f, 0.0004f, 0.0008f})
          points.emplace_back(x + 0.0005f + step, y + 0.0005f, z + 0.0005f);
  const auto voxels = voxel_grid(PclCloud{points}, config).to_vector();

  REQUIRE(voxels.size() == 8);
  for (const Eigen::Vector3f& v : voxels) {
    CHECK(std::abs(std::abs(v.x() - 0.0009f) - 8.0f) < 1e-5f);
    CHECK(std::abs(std::abs(v.y() - 0.0005f) - 8.0f) < 1e-5f);
  }
  config.voxel_leaf_m = 0;
  CHECK(voxel_grid(PclCloud{points}, config).size() == points.size());
  CHECK(voxel_grid(PclCloud{}, ThesisConfig{}).size() == 0);
}

TEST_CASE("a point far from the rest is an outlier, a small cloud is left alone", "[thesis]") {
  SampledShapes plate(0.01);
  plate.rectangle({0, 0, 1}, {0.5, 0, 0}, {0, 0.5, 0});
  const std::size_t plate_points = plate.points.size();
  plate.points.emplace_back(0.25f, 0.25f, 1.4f);
  ThesisConfig config;
  config.outlier_sigmas = 3.0;
  const auto clean = without_outliers(PclCloud{plate.points}, config).to_vector();

  CHECK(clean.size() <= plate_points);
  CHECK(clean.size() > plate_points * 9 / 10);
  for (const Eigen::Vector3f& p : clean) CHECK(p.z() < 1.1f);

  // fewer points than neighbours asked for
  const std::vector<Eigen::Vector3f> few{{0, 0, 1}, {0.01f, 0, 1}, {0, 0.01f, 1}};
  CHECK(without_outliers(PclCloud{few}, ThesisConfig{}).size() >= 2);
  CHECK(without_outliers(PclCloud{std::vector<Eigen::Vector3f>(1)}, ThesisConfig{}).size() == 1);
  CHECK(without_outliers(PclCloud{}, ThesisConfig{}).size() == 0);
}

TEST_CASE("clusters are ordered by size, and the tolerance decides whether a gap separates them",
          "[thesis]") {
  SampledShapes shapes(0.01);
  shapes
      .rectangle({0, 0, 1}, {0.2, 0, 0}, {0, 0.2, 0})     // 441 points
      .rectangle({0.24, 0, 1}, {0.3, 0, 0}, {0, 0.3, 0})  // 961 points, 4 cm beside
      .rectangle({2, 2, 1}, {0.05, 0, 0}, {0, 0.05, 0});  // 36 points
  const PclCloud cloud{shapes.points};
  ThesisConfig config;
  config.cluster_tolerance_m = 0.02;
  const auto apart = euclidean_clusters(cloud, config);
  REQUIRE(apart.size() == 2);
  CHECK(apart[0].size() == 961);
  CHECK(apart[1].size() == 441);

  config.cluster_tolerance_m = 0.05;
  config.cluster_min_points = 30;
  const auto joined = euclidean_clusters(cloud, config);
  REQUIRE(joined.size() == 2);
  CHECK(joined[0].size() == 961 + 441);
  CHECK(joined[1].size() == 36);
  CHECK(euclidean_clusters(PclCloud{}, config).empty());
}
