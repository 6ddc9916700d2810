#include "perception/thesis/thesis_surfaces.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "sampled_shapes.hpp"

using namespace colift::perception;
using colift::test::SampledShapes;

namespace {

const Vec3 kEye{2.0, 1.5, 2.0};

/// A table of 0.8 x 0.5 m, 0.45 m high, with a rail of 6 cm under the top and legs of 5 cm: the two sides and
/// the top that the eye sees.
std::vector<Eigen::Vector3f> table() {
  SampledShapes shapes(0.005, 0.001);
  shapes.rectangle({0, 0, 0.45}, {0.8, 0, 0}, {0, 0.5, 0});
  shapes.rectangle({0, 0.5, 0.39}, {0.8, 0, 0}, {0, 0, 0.06});
  shapes.rectangle({0.8, 0, 0.39}, {0, 0.5, 0}, {0, 0, 0.06});
  for (const double x : {0.0, 0.75}) shapes.rectangle({x, 0.5, 0}, {0.05, 0, 0}, {0, 0, 0.39});
  for (const double y : {0.0, 0.45}) shapes.rectangle({0.8, y, 0}, {0, 0.05, 0}, {0, 0, 0.39});
  return shapes.points;
}

ThesisConfig fine_grid() {
  ThesisConfig config;
  config.voxel_leaf_m = 0.005;
  config.rectangle_cell_m = 0.01;
  return config;
}

bool holds(const Rectangle& r, const Vec3& p) {
  const Vec3 off = p - r.center;
  return std::abs(r.normal.dot(off)) < 0.01 && std::abs(r.u.dot(off)) < r.size.x() / 2 &&
         std::abs(r.v.dot(off)) < r.size.y() / 2;
}

double area(const std::vector<Rectangle>& rectangles, const Vec3& normal) {
  double sum = 0;
  for (const Rectangle& r : rectangles)
    if (r.normal.dot(normal) > 0.99) sum += r.size.prod();
  return sum;
}

}  // namespace

TEST_CASE("a box is three rectangles with their sizes, normals towards the eye", "[thesis][surfaces]") {
  const auto rectangles =
      thesis_surfaces(SampledShapes(0.005, 0.001).box({0, 0, 0}, {0.4, 0.3, 0.5}).points, kEye, fine_grid());

  REQUIRE(rectangles.size() == 3);
  for (const Rectangle& r : rectangles) {
    CHECK(r.normal.maxCoeff() > 0.9999);
    CHECK(r.fill > 0.98);
    CHECK(r.u.cross(r.v).isApprox(r.normal, 1e-9));
    CHECK(r.size.x() >= r.size.y());
  }
  // a face that was found before takes a strip of surface_distance_m from the faces that meet it
  const auto side = [&](const Vec3& normal, double length, double width) {
    const auto r = std::find_if(rectangles.begin(), rectangles.end(),
                                [&](const Rectangle& x) { return x.normal.dot(normal) > 0.999; });
    REQUIRE(r != rectangles.end());
    CHECK(r->size.x() == Approx(length).margin(0.022));
    CHECK(r->size.y() == Approx(width).margin(0.022));
  };
  side(Vec3::UnitX(), 0.5, 0.3);
  side(Vec3::UnitY(), 0.5, 0.4);
  side(Vec3::UnitZ(), 0.4, 0.3);
}

TEST_CASE("the side of a table is mostly empty, and no rectangle covers the emptiness",
          "[thesis][surfaces]") {
  const auto rectangles = thesis_surfaces(table(), kEye, fine_grid());

  for (const Rectangle& r : rectangles) {
    CHECK(r.fill >= 0.7);
    CHECK_FALSE(holds(r, {0.4, 0.5, 0.15}));
    CHECK_FALSE(holds(r, {0.8, 0.25, 0.15}));
  }
  const auto covered = [&](const Vec3& p) {
    return std::any_of(rectangles.begin(), rectangles.end(), [&](const Rectangle& r) { return holds(r, p); });
  };
  CHECK(covered({0.4, 0.25, 0.45}));
  CHECK(covered({0.4, 0.5, 0.41}));
  CHECK(covered({0.78, 0.5, 0.1}));
  CHECK(covered({0.8, 0.02, 0.1}));
  CHECK(area(rectangles, Vec3::UnitZ()) == Approx(0.4).epsilon(0.05));
}

TEST_CASE("a stricter fill splits further and never covers less densely", "[thesis][surfaces]") {
  ThesisConfig loose = fine_grid(), strict = fine_grid();
  loose.rectangle_min_fill = 0.0;
  strict.rectangle_min_fill = 0.9;
  const auto few = thesis_surfaces(table(), kEye, loose), many = thesis_surfaces(table(), kEye, strict);

  CHECK(few.size() == 3);
  CHECK(many.size() > few.size());
  for (const Rectangle& r : many) CHECK(r.fill >= 0.9);
}

TEST_CASE("rectangles come out the same bit for bit, and nothing comes of nothing", "[thesis][surfaces]") {
  const auto a = thesis_surfaces(table(), kEye, fine_grid()), b = thesis_surfaces(table(), kEye, fine_grid());
  REQUIRE(a.size() == b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    CHECK(a[i].center == b[i].center);
    CHECK(a[i].u == b[i].u);
    CHECK(a[i].size == b[i].size);
  }
  CHECK(thesis_surfaces({}, kEye, ThesisConfig{}).empty());
  CHECK(thesis_surfaces(std::vector<Eigen::Vector3f>(500, Eigen::Vector3f::Ones()), kEye, ThesisConfig{})
            .empty());
}
