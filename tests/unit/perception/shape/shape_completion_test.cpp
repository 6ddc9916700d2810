#include <fmt/format.h>
#include <Eigen/LU>
#include <catch2/catch.hpp>

#include <iostream>

#include "tests/unit/perception/surfaces/views.hpp"

using namespace colift;
using namespace colift::perception;
using sim_hal::ObjectKind;
using Kind = CompletedShape::Kind;

namespace {

struct Figures {
  std::vector<double> horizontal_mm, vertical_mm, box_rule_mm, normalised;
  int expected = 0, frames = 0;
};

Figures measure(ObjectKind kind, Kind expected, int seeds) {
  Figures f;
  for (int seed = 1; seed <= seeds; ++seed) {
    const SurfaceView view(kind, static_cast<std::uint64_t>(seed));
    const CompletedShape shape = view.shape();
    const Vec3 e = shape.cog - view.scene.cog;
    f.horizontal_mm.push_back(1000 * e.head<2>().norm());
    f.vertical_mm.push_back(1000 * std::abs(e.z()));
    f.box_rule_mm.push_back(1000 * (view.target.aabb.center() - view.scene.cog).norm());
    f.normalised.push_back(e.dot(shape.covariance.inverse() * e));
    f.expected += shape.kind == expected;
    ++f.frames;
  }
  return f;
}

struct Row {
  ObjectKind kind;
  const char* name;
  Kind expected;
  double horizontal_mm;  // limit of the median
};
constexpr Row kRows[] = {{ObjectKind::Table, "table", Kind::Plate, 15},
                         {ObjectKind::Box, "closed box", Kind::Block, 15},
                         {ObjectKind::OpenBox, "open box", Kind::OpenBox, 15},
                         {ObjectKind::Pipe, "pipe", Kind::Cylinder, 15},
                         {ObjectKind::Chair, "chair", Kind::Chair, 40}};

double within(const std::vector<double>& values, double limit) {
  return static_cast<double>(
             std::count_if(values.begin(), values.end(), [&](double x) { return x < limit; })) /
         static_cast<double>(values.size());
}

}  // namespace

TEST_CASE("the completed shape's centroid is near the true centre of gravity and knows how near",
          "[completion]") {
  for (const Row& row : kRows) {
    const Figures f = measure(row.kind, row.expected, 24);
    INFO(row.name << ": horizontal median " << quantile(f.horizontal_mm, 0.5) << " mm");
    CHECK(quantile(f.horizontal_mm, 0.5) <= row.horizontal_mm);
    CHECK(f.expected >= 21);
    // chi-square with three degrees of freedom: median 2.4, 95 % below 7.8
    CHECK(quantile(f.normalised, 0.5) < 2.8);
    CHECK(quantile(f.normalised, 0.5) > 0.3);
    CHECK(within(f.normalised, 16.3) >= 0.85);
  }
}

// unit_perception "[figures]" prints the table of docs/decisions/0001-shape-completion.md
TEST_CASE("figures of the shape completion", "[.][figures]") {
  std::cout << fmt::format("{:<12}{:>7}{:>10}{:>26}{:>18}{:>22}{:>20}\n", "object", "frames", "as meant",
                           "horizontal mm 50/90 %", "vertical 50/90 %", "box middle mm 50/90 %",
                           "normalised 50/90 %");
  for (const Row& row : kRows) {
    const Figures f = measure(row.kind, row.expected, 50);
    std::cout << fmt::format(
        "{:<12}{:>7}{:>10}{:>16.1f} /{:>8.1f}{:>9.1f} /{:>7.1f}{:>13.1f} /{:>7.1f}{:>12.1f} /{:>6.1f}\n",
        row.name, f.frames, f.expected, quantile(f.horizontal_mm, 0.5), quantile(f.horizontal_mm, 0.9),
        quantile(f.vertical_mm, 0.5), quantile(f.vertical_mm, 0.9), quantile(f.box_rule_mm, 0.5),
        quantile(f.box_rule_mm, 0.9), quantile(f.normalised, 0.5), quantile(f.normalised, 0.9));
  }
}

TEST_CASE("the completed box holds the object down to the ground", "[completion]") {
  for (std::uint64_t seed = 60; seed < 66; ++seed) {
    const SurfaceView view(ObjectKind::Table, seed);
    const CompletedShape shape = view.shape();
    CHECK(shape.box.axes.determinant() == Approx(1.0));
    CHECK(shape.box.axes.col(2).dot(Vec3::UnitZ()) > 0.99);
    const double bottom = shape.box.center.z() - 0.5 * shape.box.size.z();
    CHECK(std::abs(bottom) < 0.01);
    const sim_hal::TrueFace& top = view.scene.faces[0];
    CHECK(shape.box.size.z() == Approx(top.center.z()).margin(0.01));
    CHECK(shape.box.size.x() == Approx(std::max(top.width, top.height)).margin(0.03));
  }
}

TEST_CASE("a plate at the height of a desk with a thing on it is no chair", "[completion]") {
  const auto plate = sim_hal::box({0, 0, 0.70}, {1.2, 0.6, 0.03}, 0.0, sim_hal::Label::Target);
  const auto thing = sim_hal::box({-0.3, 0, 0.815}, {0.3, 0.3, 0.2}, 0.0, sim_hal::Label::Target);
  const SurfaceView bare(scene_of({plate}, {1.4, 0.6, 1.6}, {0, 0, 0.6}), 1);
  const SurfaceView laden(scene_of({plate, thing}, {1.4, 0.6, 1.6}, {0, 0, 0.6}), 1);
  const CompletedShape without = bare.shape(), with = laden.shape();
  CHECK(without.kind == Kind::Plate);
  CHECK(with.kind == Kind::Plate);
  CHECK(with.reason.find("stand on it") != std::string::npos);
  // nobody knows what the thing weighs, but on which side it stands
  CHECK(with.covariance(0, 0) > without.covariance(0, 0) + 0.0005);
}

TEST_CASE("a round leg as long as the seat is wide makes no pipe of a chair", "[completion]") {
  const SurfaceView view(ObjectKind::Chair, 2);
  const CompletedShape chair = view.shape();
  REQUIRE(chair.kind == Kind::Chair);
  std::vector<Surface> surfaces = view.surfaces();
  const Vec3 corner = chair.box.center + chair.box.axes * Vec3(0.45, 0.45, 0.0).cwiseProduct(chair.box.size);
  const double length = chair.box.size.head<2>().maxCoeff();
  surfaces.push_back(Cylinder{{corner.x(), corner.y(), 0.5 * length}, Vec3::UnitZ(), 0.02, length});
  const CompletedShape with_leg =
      complete_shape(view.cloud, view.target, surfaces, view.ground, NoiseModel{});
  CHECK(with_leg.kind == Kind::Chair);
  CHECK((with_leg.cog - chair.cog).norm() < 0.02);
}

namespace {

/// Boxes, each with middle and size, as heavy as they are large.
struct Boxes {
  std::vector<sim_hal::Shape> shapes;
  Vec3 moment = Vec3::Zero();
  double volume = 0.0;

  void add(const Vec3& center, const Vec3& size) {
    shapes.push_back(sim_hal::box(center, size, 0.0, sim_hal::Label::Target));
    moment += size.prod() * center, volume += size.prod();
  }
  [[nodiscard]] Vec3 cog() const { return moment / volume; }
};

void check_cog(const CompletedShape& shape, const Vec3& truth, double level_m, double vertical_m) {
  const Vec3 e = shape.cog - truth;
  INFO(shape.reason << "\noff by " << e.transpose());
  CHECK(e.head<2>().norm() < level_m);
  CHECK(std::abs(e.z()) < vertical_m);
  CHECK(e.dot(shape.covariance.inverse() * e) < 16.3);
}

}  // namespace

TEST_CASE("a shelf is as heavy as its boards, sides and back, not a plate on legs", "[completion]") {
  Boxes shelf;
  for (const double z : {0.06, 0.40, 0.79}) shelf.add({0, 0, z}, {0.70, 0.30, 0.018});
  for (const double x : {-0.36, 0.36}) shelf.add({x, 0, 0.40}, {0.018, 0.30, 0.80});
  shelf.add({0, -0.155, 0.40}, {0.72, 0.008, 0.80});
  const SurfaceView view(scene_of(shelf.shapes, {0.5, 1.5, 1.3}, {0, 0, 0.4}), 3);
  const CompletedShape shape = view.shape();
  CHECK(shape.kind == Kind::Parts);
  check_cog(shape, shelf.cog(), 0.04, 0.06);
}

TEST_CASE("of a frame of bars nothing is taken to be where the camera looks through", "[completion]") {
  Boxes frame;  // a goal with a small plate on top
  for (const double x : {-0.4, 0.3}) frame.add({x, 0, 0.4}, {0.035, 0.035, 0.8});
  for (const double z : {0.3, 0.6}) frame.add({-0.05, 0, z}, {0.7, 0.03, 0.03});
  frame.add({-0.4, 0, 0.82}, {0.24, 0.13, 0.04});
  frame.add({0.3, 0, 0.7}, {0.03, 0.5, 0.03});
  const SurfaceView view(scene_of(frame.shapes, {0.4, 1.6, 1.3}, {0, 0, 0.4}), 3);
  const CompletedShape shape = view.shape();
  CHECK(shape.kind == Kind::Parts);
  check_cog(shape, frame.cog(), 0.06, 0.06);
}

TEST_CASE("a handle that sticks out beside a closed body does not make its top longer", "[completion]") {
  Boxes suitcase;
  suitcase.add({0, 0, 0.24}, {0.70, 0.25, 0.48});
  const Vec3 truth = suitcase.cog();
  suitcase.add({0.395, 0, 0.30}, {0.018, 0.022, 0.17});
  for (const double z : {0.22, 0.38}) suitcase.add({0.372, 0, z}, {0.045, 0.02, 0.02});
  const SurfaceView view(scene_of(suitcase.shapes, {0.7, 1.5, 1.2}, {0, 0, 0.25}), 3);
  const CompletedShape shape = view.shape();
  CHECK(shape.kind == Kind::Block);
  CHECK((shape.cog - truth).head<2>().norm() < 0.008);
}

TEST_CASE("every completion says what was assumed", "[completion]") {
  const SurfaceView table(ObjectKind::Table, 1), box(ObjectKind::Box, 1);
  CHECK(table.shape().reason.find("legs") != std::string::npos);
  CHECK(box.shape().reason.find("closed body") != std::string::npos);
  CHECK(std::string(name_of(Kind::Plate)) == "plate on legs");
}

TEST_CASE("an object of no known shape gets a centroid with a wide covariance", "[completion]") {
  const SurfaceView view(scene_of({sim_hal::sphere({0, 0, 0.2}, 0.2, sim_hal::Label::Target)}), 1);
  const CompletedShape shape = complete_shape(view.cloud, view.target, {}, view.ground, NoiseModel{});
  CHECK(shape.kind == Kind::Mirrored);
  const Vec3 e = shape.cog - Vec3(0, 0, 0.2);
  CHECK(e.norm() < 0.1);
  CHECK(e.dot(shape.covariance.inverse() * e) < 11.3);
}
