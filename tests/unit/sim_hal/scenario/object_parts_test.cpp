#include "sim_hal/scenario/object_parts.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "sim_hal/synthetic/hash_random.hpp"

using namespace colift::sim_hal;
using colift::hal::ErrorCode;

namespace {

ScenarioObject object(const std::string& kind, std::vector<double> size, double mass) {
  ScenarioObject o;
  o.kind = kind;
  o.size = std::move(size);
  o.mass = mass;
  return o;
}

/// Mass, centre and inertia by adding up the points of a fine grid in every part.
struct Counted {
  double mass = 0.0;
  Vec3 cog = Vec3::Zero();
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();
};

Counted count(const ObjectParts& parts) {
  constexpr int n = 40;
  std::vector<std::pair<Vec3, double>> points;
  for (const auto& [shape, mass] : parts.parts) {
    std::vector<Vec3> inside;
    const bool round = shape.kind == Shape::Kind::Cylinder;
    const Vec3 full = round ? Vec3(2 * shape.size[0], 2 * shape.size[0], shape.size[1]) : shape.size;
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < n; ++j)
        for (int k = 0; k < n; ++k) {
          const Vec3 p = full.cwiseProduct(Vec3(i + 0.5, j + 0.5, k + 0.5) / n - Vec3::Constant(0.5));
          if (!round || p.head<2>().norm() <= shape.size[0]) inside.push_back(shape.X_WS * p);
        }
    for (const Vec3& p : inside) points.emplace_back(p, mass / static_cast<double>(inside.size()));
  }
  Counted c;
  for (const auto& [p, m] : points) c.mass += m, c.cog += m * p;
  c.cog /= c.mass;
  for (const auto& [p, m] : points) {
    const Vec3 r = p - c.cog;
    c.inertia += m * (r.squaredNorm() * Eigen::Matrix3d::Identity() - r * r.transpose());
  }
  return c;
}

ScenarioObject bodies() {
  ScenarioObject o = object("bodies", {}, 0.0);
  o.parts.push_back({"box", {0.3, 0.2, 0.1}, {0.1, 0.2, 0.3}, {20, -35, 70}, 1.2});
  o.parts.push_back({"cylinder", {0.06, 0.5}, {-0.2, 0.1, 0.4}, {90, 10, 0}, 0.7});
  return o;
}

const ScenarioObject kObjects[] = {
    object("table", {0.8, 0.5, 0.45}, 4.0),
    object("box", {0.9, 0.16, 0.25}, 3.5),
    object("cylinder", {0.04, 1.2}, 3.0),
    object("chair", {0.44, 0.42, 0.85}, 4.0),
    bodies(),
};

}  // namespace

TEST_CASE("mass, centre of gravity and inertia agree with counting points", "[scenario][object_parts]") {
  for (const ScenarioObject& o : kObjects) {
    CAPTURE(o.kind);
    const auto parts = object_parts(o);
    REQUIRE(parts);
    const Counted c = count(*parts);
    CHECK(parts->mass_kg == Approx(c.mass).epsilon(1e-9));
    if (o.kind != "bodies") CHECK(parts->mass_kg == Approx(o.mass).epsilon(1e-12));
    CHECK((parts->cog_T - c.cog).norm() < 1e-3);
    // a grid of 40 cells misses 1/40^2 of a moment, and a little more on round pieces
    CHECK((parts->inertia_T - c.inertia).norm() < 0.005 * c.inertia.norm());
    CHECK((parts->inertia_T - parts->inertia_T.transpose()).norm() < 1e-12);
  }
}

TEST_CASE("density is the same in all pieces but of bodies", "[scenario][object_parts]") {
  for (const ScenarioObject& o : kObjects) {
    if (o.kind == "bodies") continue;
    const auto parts = object_parts(o);
    REQUIRE(parts);
    const auto density = [](const ObjectParts::Part& p) {
      const bool round = p.shape.kind == Shape::Kind::Cylinder;
      return p.mass_kg / (round ? std::numbers::pi * std::pow(p.shape.size[0], 2) * p.shape.size[1]
                                : p.shape.size.prod());
    };
    for (const auto& part : parts->parts) CHECK(density(part) == Approx(density(parts->parts[0])));
  }
}

TEST_CASE("an object stands on the floor, is as large as it says, and its pieces do not overlap",
          "[scenario][object_parts]") {
  for (const ScenarioObject& o : kObjects) {
    if (o.kind == "bodies") continue;
    CAPTURE(o.kind);
    const auto parts = object_parts(o);
    REQUIRE(parts);
    World world;
    for (const auto& part : parts->parts) world.shapes.push_back(part.shape);
    const Vec3 size = o.kind == "cylinder" ? Vec3(o.size[1], 2 * o.size[0], 2 * o.size[0])
                                           : Vec3(o.size[0], o.size[1], o.size[2]);
    // the smallest and largest places that are solid, along each axis, found from a grid
    colift::hal::Aabb solid;
    double doubly = 0.0;
    constexpr double kStep = 0.007;
    for (double x = -1.2; x < 1.2; x += kStep)
      for (double y = -0.6; y < 0.6; y += kStep)
        for (double z = -0.1; z < 1.0; z += kStep) {
          const Vec3 p(x, y, z);
          int in = 0;
          if (std::abs(x) > 0.5 * size.x() + 0.02 || std::abs(y) > 0.5 * size.y() + 0.02) continue;
          for (const Shape& s : world.shapes) in += distance(s, p) < 0.0;
          if (in > 0) solid.extend(p);
          doubly += in > 1;
        }
    CHECK(doubly == 0);
    CHECK((solid.min() - Vec3(-0.5 * size.x(), -0.5 * size.y(), 0)).cwiseAbs().maxCoeff() < 2 * kStep);
    CHECK((solid.max() - Vec3(0.5 * size.x(), 0.5 * size.y(), size.z())).cwiseAbs().maxCoeff() < 2 * kStep);
  }
}

TEST_CASE("an offset moves the centre of gravity alone", "[scenario][object_parts]") {
  ScenarioObject o = object("table", {0.8, 0.5, 0.45}, 4.0);
  const auto before = object_parts(o);
  o.cog_offset = {0.12, -0.1, -0.05};
  const auto after = object_parts(o);
  REQUIRE(before);
  REQUIRE(after);
  CHECK((after->cog_T - before->cog_T - o.cog_offset).norm() < 1e-15);
  CHECK(after->inertia_T == before->inertia_T);
  o.cog_offset = {0.41, 0, 0};
  const auto outside = object_parts(o);
  REQUIRE_FALSE(outside);
  CHECK(outside.error().code == ErrorCode::BadConfig);
  CHECK(outside.error().where == "object.cog_offset");
}

TEST_CASE("sizes that make no object are refused", "[scenario][object_parts]") {
  const ScenarioObject bad[] = {object("table", {0.1, 0.5, 0.45}, 1), object("table", {0.5, 0.5, 0.05}, 1),
                                object("table", {0.5, 0.5}, 1),       object("chair", {0.4, 0.4, 0.2}, 1),
                                object("cylinder", {0.1}, 1),         object("box", {}, 1),
                                object("sofa", {1, 1, 1}, 1),         object("bodies", {}, 1)};
  for (const ScenarioObject& o : bad) {
    const auto parts = object_parts(o);
    REQUIRE_FALSE(parts);
    CHECK(parts.error().code == ErrorCode::BadConfig);
    CHECK_FALSE(parts.error().detail.empty());
  }
}

TEST_CASE("clutter stands on its lowest middle point", "[scenario][object_parts]") {
  Scenario s;
  s.clutter.push_back({"box", {0.2, 0.4, 0.6}, {1, 2, 0.1}, 90});
  s.clutter.push_back({"cylinder", {0.1, 0.5}, {0, 1, 0}, 0});
  const auto shapes = clutter_shapes(s);
  REQUIRE(shapes.size() == 2);
  // by their own distance function: just inside and just outside
  CHECK(distance(shapes[0], {1, 2, 0.101}) < 0);
  CHECK(distance(shapes[0], {1, 2, 0.099}) > 0);
  CHECK(distance(shapes[0], {1.199, 2, 0.4}) < 0);  // turned: the long side lies along x
  CHECK(distance(shapes[0], {1, 2.101, 0.4}) > 0);
  CHECK(distance(shapes[1], {0.099, 1, 0.499}) < 0);
  CHECK(distance(shapes[1], {0, 1, 0.501}) > 0);
  CHECK(shapes[1].label == Label::Clutter);
}
