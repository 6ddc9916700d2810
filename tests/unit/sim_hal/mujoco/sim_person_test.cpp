#include "sim_hal/mujoco/sim_person.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <filesystem>
#include <limits>

#include "sim_hal/scenario/object_parts.hpp"

using namespace colift::sim_hal;

namespace {

struct Grasp {
  World world;  // ground, object and clutter
  Vec3 contact, middle;
};

/// Every shipped scenario with a person.
std::vector<std::pair<std::string, Grasp>> shipped() {
  std::vector<std::pair<std::string, Grasp>> all;
  for (const auto& entry : std::filesystem::directory_iterator(COLIFT_SOURCE_DIR "/config/scenario")) {
    const auto s = load_scenario(entry.path());
    REQUIRE(s);
    if (s->partner.kind == "none" || s->partner.kind == "support") continue;
    Grasp g;
    const Pose X_WT = object_pose(s->object);
    const auto parts = object_parts(s->object);
    REQUIRE(parts);
    for (const auto& part : parts->parts) {
      g.world.shapes.push_back(part.shape);
      g.world.shapes.back().X_WS = X_WT * part.shape.X_WS;
    }
    for (const Shape& shape : clutter_shapes(*s)) g.world.shapes.push_back(shape);
    g.contact = X_WT * s->partner.grasp;
    g.middle = X_WT * parts->cog_T;
    all.emplace_back(s->name, g);
  }
  return all;
}

std::vector<Shape> person(const World& world, const PartnerFigure& figure) {
  World with = world;
  add_partner(with, figure);
  for (std::size_t i = world.shapes.size(); i < with.shapes.size(); ++i)
    CHECK(with.shapes[i].label == Label::Partner);
  return {with.shapes.begin() + static_cast<std::ptrdiff_t>(world.shapes.size()), with.shapes.end()};
}

double nearest(const std::vector<Shape>& shapes, const Vec3& p) {
  double d = std::numeric_limits<double>::infinity();
  for (const Shape& s : shapes) d = std::min(d, distance(s, p));
  return d;
}

/// Smallest gap of body and limbs to the object, the hand left out.
double gap(const std::vector<Shape>& shapes, const Grasp& g) {
  double d = std::numeric_limits<double>::infinity();
  for (const Shape& s : shapes) {
    if (s.kind == Shape::Kind::Box) continue;
    const double half = s.kind == Shape::Kind::Capsule ? 0.5 * s.size[1] : 0.0;
    for (int i = -10; i <= 10; ++i) {
      const Vec3 p = s.X_WS.translation() + 0.1 * i * half * s.X_WS.linear().col(2);
      if ((p - g.contact).norm() > 0.17) d = std::min(d, distance(g.world, Label::Target, p) - s.size[0]);
    }
  }
  return d;
}

}  // namespace

TEST_CASE("the person's hand is on the contact, and he stands outside of it and not in the object",
          "[sim][person]") {
  for (const auto& [name, g] : shipped()) {
    CAPTURE(name);
    const PartnerFigure figure = place_partner(g.world, g.contact, g.contact - g.middle);
    const auto shapes = person(g.world, figure);
    CHECK(shapes.size() > 15);
    CHECK(nearest(shapes, g.contact) < 0.03);
    CHECK(gap(shapes, g) > 0.0);
    REQUIRE(figure.shoulder_W);
    CHECK(figure.outward_W.dot(*figure.shoulder_W) > 0.0);
  }
}

TEST_CASE("a person who has drawn back touches nothing, and one who is away is not there", "[sim][person]") {
  for (const auto& [name, g] : shipped()) {
    CAPTURE(name);
    PartnerFigure figure = place_partner(g.world, g.contact, g.contact - g.middle);
    figure.presence = 0.5;
    const auto back = person(g.world, figure);
    CHECK(nearest(back, g.contact) > 0.12);
    for (const Shape& s : back)
      if (s.kind != Shape::Kind::Box)
        CHECK(distance(g.world, Label::Target, s.X_WS.translation()) > s.size[0] - 0.001);
    figure.presence = 0.2;
    CHECK(nearest(person(g.world, figure), g.contact) > 0.5);
    figure.presence = 0.0;
    CHECK(person(g.world, figure).empty());
  }
}

TEST_CASE("he comes without a leap from frame to frame, and rises with the object", "[sim][person]") {
  const auto all = shipped();
  const Grasp& g = all.front().second;
  PartnerFigure figure = place_partner(g.world, g.contact, g.contact - g.middle);
  std::vector<Shape> before;
  for (int frame = 1; frame <= 30; ++frame) {
    figure.presence = presence_at(-1.0 + frame / 30.0);
    const auto now = person(g.world, figure);
    if (!before.empty()) {
      REQUIRE(now.size() == before.size());
      for (std::size_t i = 0; i < now.size(); ++i)
        CHECK((now[i].X_WS.translation() - before[i].X_WS.translation()).norm() < 0.25);  // 7.5 m/s of a hand
    }
    before = now;
  }
  World lifted = g.world;
  for (Shape& s : lifted.shapes) s.X_WS.translation().z() += 0.05;
  figure.contact_W.z() += 0.05;
  CHECK(nearest(person(lifted, figure), figure.contact_W) < 0.03);
}

TEST_CASE("who steps aside goes the way that he was asked to, around his hand and not into the object",
          "[sim][person]") {
  for (const auto& [name, g] : shipped()) {
    for (const double side : {1.0, -1.0}) {
      CAPTURE(name, side);
      PartnerFigure figure = place_partner(g.world, g.contact, g.contact - g.middle);
      const Vec3 from = *figure.shoulder_W;
      const Vec3 direction_W = side * Vec3::UnitZ().cross(from).normalized();
      const auto to = step_aside(g.world, figure, direction_W);
      if (!to) continue;  // no room on that side
      CHECK((*to - from).dot(direction_W) > 0.1);
      CHECK(to->norm() == Approx(from.norm()));
      CHECK(turned(from, *to, 0.0).isApprox(from));
      CHECK(turned(from, *to, 1.0).isApprox(*to));
      const double before = gap(person(g.world, figure), g);
      figure.shoulder_W = to;
      CHECK(gap(person(g.world, figure), g) > std::min(before, 0.0) - 1e-9);
      CHECK(nearest(person(g.world, figure), g.contact) < 0.03);
    }
  }
}

TEST_CASE("whoever is asked to step aside towards himself stays", "[sim][person]") {
  const auto all = shipped();
  const Grasp& g = all.front().second;
  const PartnerFigure figure = place_partner(g.world, g.contact, g.contact - g.middle);
  CHECK_FALSE(step_aside(g.world, figure, *figure.shoulder_W));
}

TEST_CASE("presence follows arrival and letting go", "[sim][person]") {
  CHECK(presence_at(-5.0) == 0.0);
  CHECK(presence_at(-0.5) == Approx(0.5));
  CHECK(presence_at(0.0) == 1.0);
  CHECK(presence_at(9.0) == 1.0);
  CHECK(presence_at(9.0, -1.0) == 1.0);
  CHECK(presence_at(9.0, 0.2) == Approx(0.75));
  CHECK(presence_at(9.0, 3.0) == Approx(0.5));
}

TEST_CASE(
    "a hand goes round a handle, and keeps its grip when the handle moves by a hundredth of a millimetre",
    "[sim][person]") {
  const auto holding = [](double moved_m) {
    World world;
    Shape bar = box(Vec3(0.045, moved_m, 0.4), Vec3(0.018, 0.022, 0.17), 0.0, Label::Target);
    world.shapes = {box(Vec3(-0.3, moved_m, 0.25), Vec3(0.6, 0.24, 0.5), 0.0, Label::Target), bar};
    PartnerFigure figure = place_partner(world, Vec3(0.054, 0, 0.4), Vec3::UnitX());
    figure.shoulder_W = Vec3(0.5, 0.0, 0.3);
    return person(world, figure);
  };
  const auto before = holding(1e-5), after = holding(-1e-5);
  REQUIRE(before.size() == after.size());
  double palm_off_m = 1.0;
  for (std::size_t i = 0; i < before.size(); ++i) {
    CHECK((before[i].X_WS.translation() - after[i].X_WS.translation()).norm() < 1e-3);
    palm_off_m = std::min(palm_off_m, std::abs(distance(before[i], Vec3(0.054, 0, 0.4))));
  }
  CHECK(palm_off_m < 0.005);
  // fingers on both sides of it
  CHECK(nearest(before, Vec3(0.045, 0.02, 0.4)) < 0.01);
  CHECK(nearest(before, Vec3(0.045, -0.02, 0.4)) < 0.01);
}
