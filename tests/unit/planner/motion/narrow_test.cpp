#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "hal/robot_model/robot_model.hpp"
#include "planner/motion/motion_planner.hpp"
#include "planner/motion/trajectory/timing.hpp"
#include "planning_world.hpp"

namespace {

using namespace colift;
using hal::JointVector;
using hal::Vec3;
using planner::MotionPlanner;
using sim_hal::Label;
using tests::TableAt;

constexpr double kLift = 0.05;

void check_plan(const sim_hal::World& truth, const planner::GraspCandidate& grasp) {
  const auto world = tests::see_from_all_sides(truth);
  MotionPlanner planner(hal::built_in_robot(), planner::HandModel{}, {}, 1);
  planner.set_scene(world.scene, world.map, Vec3::UnitZ());
  const auto plan = planner.plan(tests::home_rad(), grasp, kLift);
  if (!plan) FAIL(plan.error().text());
  double transit = 0.0, approach = 0.0;
  for (const JointVector& q : planner::sampled(plan->transit, 0.03)) {
    transit = std::max(transit, tests::penetration_m(hal::built_in_robot(), q, truth));
  }
  for (const JointVector& q : planner::sampled(plan->approach, 0.03)) {
    approach = std::max(approach, tests::penetration_m(hal::built_in_robot(), q, truth, Label::Target));
  }
  CHECK(transit == 0.0);
  CHECK(approach == 0.0);
}

}  // namespace

TEST_CASE("the arm goes under a table's top to a bar there") {
  sim_hal::World truth;
  tests::add_floor(truth);
  TableAt table;
  table.label = Label::Clutter;
  table.x = 0.78;
  table.size = {0.5, 0.9, 0.75};
  tests::add_table(truth, table);
  truth.shapes.push_back(sim_hal::box({0.78, 0, 0.35}, {0.03, 0.6, 0.03}, 0.0, Label::Target));
  check_plan(truth, tests::grasp_at({0.765, 0.05, 0.35}, Vec3::UnitX(), Vec3::UnitZ(), 0.03));
}

TEST_CASE("the arm goes between a table's legs to the bar behind them") {
  sim_hal::World truth;
  tests::add_floor(truth);
  TableAt table;
  table.x = 0.9;
  table.size = {0.4, 0.6, 0.7};
  tests::add_table(truth, table);
  truth.shapes.push_back(sim_hal::box({0.9, 0, 0.3}, {0.025, 0.56, 0.025}, 0.0, Label::Target));
  check_plan(truth, tests::grasp_at({0.8875, 0.0, 0.3}, Vec3::UnitX(), Vec3::UnitZ(), 0.025));
}

TEST_CASE("the arm goes through a gap between two walls") {
  sim_hal::World truth;
  tests::add_floor(truth);
  for (const double side : {-1.0, 1.0}) {
    truth.shapes.push_back(sim_hal::box({0.45, side * 0.47, 0.45}, {0.06, 0.6, 0.9}, 0.0, Label::Clutter));
  }
  truth.shapes.push_back(sim_hal::box({0.8, 0, 0.4}, {0.03, 0.03, 0.8}, 0.0, Label::Target));
  check_plan(truth, tests::grasp_at({0.785, 0.0, 0.5}, Vec3::UnitX(), Vec3::UnitY(), 0.03));
}

TEST_CASE("a way that does not exist is given up within its budget, and says so") {
  sim_hal::World truth;
  tests::add_floor(truth);
  // a ring around the forearm, smaller than the open hand: neither over the hand nor around it leads a way
  JointVector ringed = JointVector::Zero();
  ringed[1] = 0.2;
  ringed[3] = 0.2 + 0.5 * std::numbers::pi;
  const double z = 0.3105 + 0.4 * std::cos(0.2), x = 0.13, half = 0.105, out = 0.6;
  for (const double side : {-1.0, 1.0}) {
    truth.shapes.push_back(
        sim_hal::box({x, side * 0.5 * (half + out), z}, {0.03, out - half, 2.0 * half}, 0.0, Label::Clutter));
    truth.shapes.push_back(
        sim_hal::box({x, 0.0, z + side * (half + 0.05)}, {0.03, 2.0 * out, 0.1}, 0.0, Label::Clutter));
  }
  const auto world = tests::see_from_all_sides(truth);
  planner::PlannerConfig config;
  config.planning_budget_s = 0.05;
  MotionPlanner planner(hal::built_in_robot(), planner::HandModel{}, config, 1);
  planner.set_scene(world.scene, world.map, Vec3::UnitZ());
  JointVector outside = JointVector::Zero();
  outside[0] = 2.5;
  outside[1] = -0.6;
  outside[3] = 1.2;
  const auto stay = planner.plan_to(ringed, ringed);
  if (!stay) FAIL(stay.error().text());
  const auto out_of_it = planner.plan_to(ringed, outside);
  REQUIRE_FALSE(out_of_it);
  CHECK(out_of_it.error().where == "plan.transit");
  CHECK_THAT(out_of_it.error().detail, Catch::Contains("random joint positions"));
}

TEST_CASE("a start that is too near to something but touches nothing is left first") {
  sim_hal::World truth;
  tests::add_floor(truth);
  const hal::RobotModel& robot = hal::built_in_robot();
  // a plate a few millimetres below the palm's lowest solids
  JointVector start = tests::home_rad();
  start[1] = 0.2;
  start[3] = 1.7;
  std::vector<hal::Pose> X_WL;
  hal::link_poses(robot, start, hal::coupled_posture(0.0), X_WL);
  const Vec3 palm = X_WL[static_cast<std::size_t>(robot.palm)].translation();
  double z = palm.z() - 0.5;
  const auto with_plate = [&](double height) {
    sim_hal::World w = truth;
    w.shapes.push_back(
        sim_hal::box({palm.x() + 0.05, palm.y(), height}, {0.3, 0.4, 0.04}, 0.0, Label::Clutter));
    return w;
  };
  while (tests::penetration_m(robot, start, with_plate(z + 0.005)) == 0.0) z += 0.005;
  truth = with_plate(z - 0.03);
  const auto world = tests::see_from_all_sides(truth);
  planner::FastChecker fast(robot, planner::cover_with_spheres(robot), world.scene);
  planner::ExactChecker exact(robot, world.map, world.scene->ground);
  fast.set_hand(hal::coupled_posture(0.0));
  exact.set_hand(hal::coupled_posture(0.0));
  exact.allow(planner::Contacts::None);
  // down to it in fractions of a millimetre: cells of 2 cm leave no gap of a chosen width
  for (int i = 0; i < 400 && fast.is_free(start); ++i) start[3] += 0.0005;
  REQUIRE_FALSE(fast.is_free(start));
  REQUIRE(exact.what_touches(start).with == planner::Touch::With::Nothing);

  MotionPlanner planner(robot, planner::HandModel{}, {}, 1);
  planner.set_scene(world.scene, world.map, Vec3::UnitZ());
  JointVector goal = tests::home_rad();
  goal[0] = 1.2;
  const auto way = planner.plan_to(start, goal);
  if (!way) FAIL(way.error().text());
  CHECK(way->start().isApprox(start, 1e-9));
  CHECK(way->goal().isApprox(goal, 1e-9));
  for (const JointVector& q : planner::sampled(*way, 0.03)) {
    CHECK(tests::penetration_m(robot, q, truth) == 0.0);
  }
}
