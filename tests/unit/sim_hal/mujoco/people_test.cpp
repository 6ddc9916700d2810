#include <catch2/catch.hpp>
#include <cmath>

#include "lift_rig.hpp"

namespace colift::sim_hal {
namespace {

/// Nothing but the arm, the object far away.
Scenario empty_room() {
  Scenario s = table_scenario();
  s.object.xyz = {3.0, 0.0, 0.0};
  s.partner.kind = "none";
  return s;
}

ScenarioPerson hand_at_point(const Vec3& point) {
  ScenarioPerson p;
  p.path = {{point.x(), point.y() + 0.75}};
  p.action = "reach";
  p.reach_to = "point";
  p.point = point;
  return p;
}

double peak_n(LiftRig& rig, double time_s) {
  double peak = 0.0;
  for (int i = 0; i < static_cast<int>(time_s * 1000); ++i) {
    rig.world().advance(std::chrono::milliseconds(1));
    for (const BodyContact& c : rig.world().body_contacts()) peak = std::max(peak, c.force_n);
  }
  return peak;
}

}  // namespace

TEST_CASE("a hand at 0.25 m/s against a free hand presses as the reference table says") {
  Scenario s = empty_room();
  s.people = {hand_at_point({0.60, 0.15, 0.60})};
  LiftRig rig(s, hand_at({0.60, -0.15, 0.60}, Vec3::UnitX(), Vec3::UnitZ()));
  rig.wait(2.5);
  CHECK(rig.world().body_contacts().empty());
  const double distance = rig.world().people_distance_m();
  CHECK(distance > 0.05);
  CHECK(distance < 0.3);
  double peak = 0.0, closing = 0.0;
  // 0.3 m, min-jerk: 0.25 m/s in the middle
  const auto watch = [&] {
    for (const BodyContact& c : rig.world().body_contacts()) {
      CHECK(c.region == BodyRegion::Hand);
      if (peak == 0.0) closing = c.closing_m_s;
      peak = std::max(peak, c.force_n);
    }
  };
  rig.move_watched({0.60, 0.15, 0.60}, 0.3 * 1.875 / 0.25, watch);
  CHECK(closing == Approx(0.25).margin(0.06));
  CHECK(peak / closing == Approx(52.0 / 0.25).epsilon(0.25));
  CHECK(rig.world().truth().robot_hit_something);
}

TEST_CASE("who stands where the arm is at the start is refused") {
  Scenario s = empty_room();
  ScenarioPerson p;
  p.path = {{0.25, 0.0}};
  s.people = {hand_at_point({2.0, 1.0, 1.0}), p};
  const auto world = SimWorld::make(s, hal::built_in_robot(), 1, {});
  REQUIRE_FALSE(world);
  CHECK(world.error().where == "people[1].path");
}

TEST_CASE("a room with somebody who touches nothing moves as one without him, bit for bit") {
  Scenario s = table_scenario();
  const auto run = [&] {
    LiftRig rig(s, before_edge());
    rig.move(around_edge(), 0.5);
    rig.close();
    rig.wait(0.2);
    return rig.world().truth();
  };
  const SimTruth alone = run();
  ScenarioPerson p;
  p.path = {{2.5, 2.0}, {1.2, 1.5}};
  s.people = {p};
  const SimTruth with_him = run();
  CHECK((alone.X_WT.matrix().array() == with_him.X_WT.matrix().array()).all());
  CHECK((alone.q_rad.array() == with_him.q_rad.array()).all());
}

TEST_CASE("he is observed where he is felt, and a hand that leans on the arm is measured") {
  Scenario s = empty_room();
  ScenarioPerson p = hand_at_point({0.60, 0.0, 0.62});
  p.reach_to = "robot-hand";
  s.people = {p};
  LiftRig rig(s, hand_at({0.60, 0.0, 0.60}, Vec3::UnitX(), Vec3::UnitZ()));
  rig.wait(4.0);
  REQUIRE_FALSE(rig.world().body_contacts().empty());
  const BodyContact c = rig.world().body_contacts().front();
  CHECK(c.by == BodyContact::By::Robot);
  CHECK(c.force_n > 2.0);
  CHECK(c.force_n < 60.0);  // what his muscles hold
  CHECK(std::abs(distance(rig.world().shapes(), Label::Partner, c.at_W)) < 0.01);
  CHECK(rig.world().arm_state().tau_external_nm.norm() > 0.3);
}

TEST_CASE("who walks against the robot's base walks against furniture") {
  Scenario s = empty_room();
  ScenarioPerson p;
  p.path = {{0.0, -2.0}, {0.0, -0.1}};
  s.people = {p};
  LiftRig rig(s, hand_at({0.60, 0.0, 0.60}, Vec3::UnitX(), Vec3::UnitZ()));
  int low = 0;
  for (int i = 0; i < 3000; ++i) {
    rig.world().advance(std::chrono::milliseconds(1));
    for (const BodyContact& c : rig.world().body_contacts()) {
      if (c.at_W.z() > 0.1) continue;
      ++low;
      CHECK(c.by == BodyContact::By::Static);
      CHECK(c.force_n > 0.0);
    }
  }
  CHECK(low > 10);
}

TEST_CASE("a person who walks against a table pushes it") {
  Scenario s = empty_room();
  ScenarioPerson p;
  p.path = {{3.0, 2.0}, {3.0, 0.2}};
  s.people = {p};
  LiftRig rig(s, hand_at({0.60, 0.0, 0.60}, Vec3::UnitX(), Vec3::UnitZ()));
  CHECK(peak_n(rig, 3.0) > 20.0);
  CHECK(rig.world().truth().X_WT.translation().y() < -0.02);
  CHECK(rig.world().truth().divergences == 0);
}

TEST_CASE("the partner who carries is solid to the arm, and nothing to the object in his hand") {
  // he comes to where his arm has to go through the robot's hand
  Scenario s = table_scenario();
  s.object.size = {0.3, 0.3, 0.45};
  s.object.xyz = {0.60, 0.48, 0.0};
  s.partner.grasp = {0.0, -0.15, 0.4375};
  s.partner.arrives_s = 2.0;
  LiftRig rig(s, hand_at({0.60, 0.0, 0.60}, Vec3::UnitX(), Vec3::UnitZ()));
  rig.wait(0.9);
  CHECK(rig.world().body_contacts().empty());
  double peak = 0.0;
  for (int i = 0; i < 2500; ++i) {
    rig.world().advance(std::chrono::milliseconds(1));
    for (const BodyContact& c : rig.world().body_contacts()) {
      CHECK(c.person == kPartner);
      CHECK(c.by == BodyContact::By::Robot);
      peak = std::max(peak, c.force_n);
    }
  }
  CHECK(peak > 5.0);
  CHECK(rig.world().partner_distance_m() < 0.05);
}

TEST_CASE("somebody enters so long after a state of the task") {
  Scenario s = empty_room();
  ScenarioPerson p;
  p.in_state = "approach";
  p.enters_s = 0.3;
  p.path = {{2.0, 1.0}};
  s.people = {p};
  LiftRig rig(s, hand_at({0.60, 0.0, 0.60}, Vec3::UnitX(), Vec3::UnitZ()));
  rig.wait(1.0);
  CHECK(std::isinf(rig.world().people_distance_m()));
  rig.world().task_state("approach");
  rig.wait(0.25);
  CHECK(std::isinf(rig.world().people_distance_m()));
  rig.wait(0.1);
  CHECK(std::isfinite(rig.world().people_distance_m()));
}

TEST_CASE("clutter that is moved is seen and felt where it is") {
  Scenario s = empty_room();
  ScenarioClutter c;
  c.size = {0.1, 0.1, 0.7};
  c.xyz = {0.6, 1.0, 0.0};
  c.moves = {{1.0, {0.6, -0.08, 0.0}, 0.5}};
  s.clutter = {c};
  LiftRig rig(s, hand_at({0.60, -0.10, 0.60}, Vec3::UnitX(), Vec3::UnitZ()));
  rig.wait(2.0);
  CHECK(distance(rig.world().shapes(), Label::Clutter, {0.6, 0.5, 0.3}) == Approx(-0.05).margin(0.01));
  CHECK_FALSE(rig.world().truth().robot_hit_something);
  rig.wait(1.5);
  CHECK(rig.world().truth().robot_hit_something);
}

}  // namespace colift::sim_hal
