#include <catch2/catch.hpp>
#include <cmath>

#include "sim_hal/people/scripted_person.hpp"

using namespace colift::sim_hal;

namespace {

ScenarioPerson walker() {
  ScenarioPerson p;
  p.enters_s = 0.5;
  p.path = {{2.0, 0.0}, {0.8, 0.0}};
  p.speed = 1.2;
  return p;
}

World at(const ScenarioPerson& script, double t_s, const PersonView& view = {}) {
  ScriptedPerson person(script);
  for (double t = 0.0; t < t_s; t += 0.001) person.tick(t, view, false, false);
  World world;
  person.add_to(world);
  return world;
}

double highest(const World& world) {
  double top = 0.0;
  for (const Shape& s : world.shapes) top = std::max(top, s.X_WS.translation().z() + s.size[0]);
  return top;
}

}  // namespace

TEST_CASE("a person comes in at his time, walks his path at his speed and stands at its end") {
  CHECK(at(walker(), 0.4).shapes.empty());
  const auto chest_x = [](const World& w) {
    for (const Shape& s : w.shapes)
      if (s.part == BodyPart::Trunk) return s.X_WS.translation().x();
    return double(NAN);
  };
  CHECK(chest_x(at(walker(), 1.0)) == Approx(2.0 - 1.2 * 0.5).margin(0.01));
  CHECK(chest_x(at(walker(), 5.0)) == Approx(0.8).margin(0.01));
  CHECK(highest(at(walker(), 5.0)) == Approx(1.75).margin(0.03));
}

TEST_CASE("he crouches, sits, and goes when he is to go") {
  ScenarioPerson p = walker();
  p.action = "crouch";
  CHECK(highest(at(p, 4.0)) < 1.15);
  p.action = "sit";
  CHECK(highest(at(p, 4.0)) < 1.35);
  p.leaves_s = 4.0;
  CHECK_FALSE(at(p, 4.5).shapes.empty());
  CHECK(at(p, 8.0).shapes.empty());
}

TEST_CASE("his fingertips reach the point, as far as an arm and a lean go") {
  ScenarioPerson p = walker();
  p.action = "reach";
  p.reach_to = "point";
  for (const Vec3& point : {Vec3(0.2, 0.1, 0.9), Vec3(0.3, -0.3, 0.3), Vec3(0.4, 0.0, 1.3)}) {
    p.point = point;
    CHECK(std::abs(distance(at(p, 6.0), Label::Partner, point)) < 0.015);
  }
  p.point = {-2.0, 0.0, 1.0};
  CHECK(distance(at(p, 6.0), Label::Partner, p.point) > 1.0);
}

TEST_CASE("a foot waits beside an object on the floor and goes under it when it is lifted") {
  ScenarioPerson p = walker();
  p.path = {{0.8, 0.9}};
  p.action = "reach";
  p.reach_to = "under-object";
  p.with_foot = true;
  const auto under = [&](double height) {
    const std::vector<Shape> object{box({0.8, 0.0, 0.1 + height}, {0.4, 0.6, 0.2}, 0.0, Label::Target)};
    PersonView view;
    view.object = &object;
    double nearest = INFINITY;
    for (const Shape& s : at(p, 4.0, view).shapes)
      if (s.part == BodyPart::Foot) nearest = std::min(nearest, std::abs(s.X_WS.translation().y()));
    return nearest;
  };
  CHECK(under(0.0) > 0.38);
  CHECK(under(0.06) < 0.34);
}

TEST_CASE("who is blocked does not walk on") {
  ScriptedPerson person(walker());
  for (double t = 0.0; t < 1.0; t += 0.001) person.tick(t, {}, false, false);
  World before, after;
  person.add_to(before);
  for (double t = 1.0; t < 3.0; t += 0.001) person.tick(t, {}, true, false);
  person.add_to(after);
  CHECK((before.shapes[0].X_WS.translation() - after.shapes[0].X_WS.translation()).norm() < 1e-6);
  // nor when what he met has yielded
  World later;
  for (double t = 3.0; t < 4.0; t += 0.001) person.tick(t, {}, false, false);
  person.add_to(later);
  CHECK((before.shapes[0].X_WS.translation() - later.shapes[0].X_WS.translation()).norm() < 1e-6);
}
