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
using planner::MotionPlan;
using planner::MotionPlanner;
using sim_hal::Label;
using tests::TableAt;

constexpr double kLift = 0.05;
constexpr double kSideNear = std::numbers::pi;  // the side of a table that looks to the robot

sim_hal::World one_table(const TableAt& table) {
  sim_hal::World world;
  tests::add_floor(world);
  tests::add_table(world, table);
  return world;
}

MotionPlanner planner_in(const tests::PlanningWorld& world, const planner::PlannerConfig& config = {},
                         std::uint64_t seed = 1) {
  MotionPlanner planner(hal::built_in_robot(), planner::HandModel{}, config, seed);
  planner.set_scene(world.scene, world.map, Vec3::UnitZ());
  return planner;
}

/// How deep the robot's solids go into the true world along a trajectory (m).
double deepest(const planner::Trajectory& trajectory, const sim_hal::World& truth,
               Label allowed = Label::Nothing) {
  double out = 0.0;
  for (const JointVector& q : planner::sampled(trajectory, 0.1)) {
    out = std::max(out, tests::penetration_m(hal::built_in_robot(), q, truth, allowed));
  }
  return out;
}

void check_limits(const planner::Trajectory& trajectory, const planner::PlannerConfig& config) {
  const hal::RobotModel& robot = hal::built_in_robot();
  const JointVector margin = JointVector::Constant(config.limit_margin_deg * std::numbers::pi / 180.0);
  const JointVector lower = robot.lower_rad() + margin, upper = robot.upper_rad() - margin;
  const JointVector fastest = config.velocity_fraction * robot.velocity_rad_s();
  bool inside = true, slow = true, gentle = true;
  for (double t = 0.0; t <= trajectory.duration_s(); t += 0.004) {
    const planner::JointSample s = trajectory.sample(t);
    inside = inside && (s.q_rad.array() >= lower.array() - 1e-9).all() &&
             (s.q_rad.array() <= upper.array() + 1e-9).all();
    slow = slow && (s.dq_rad_s.array().abs() <= fastest.array() + 1e-9).all();
    gentle = gentle && (s.ddq_rad_s2.array().abs() <= config.acceleration_rad_s2 + 1e-9).all();
  }
  CHECK(inside);
  CHECK(slow);
  CHECK(gentle);
}

}  // namespace

TEST_CASE("the arm gets to the near edge of a table: straight in, within limits, touching nothing") {
  const TableAt table;
  const auto world = tests::see_from_all_sides(one_table(table));
  const planner::PlannerConfig config;
  MotionPlanner planner = planner_in(world, config);
  const hal::RobotModel& robot = hal::built_in_robot();
  for (const double along : {-0.2, 0.0, 0.15}) {
    INFO("along " << along);
    const auto grasp = tests::plate_grasp(table, kSideNear, along);
    const auto plan = planner.plan(tests::home_rad(), grasp, kLift);
    if (!plan) FAIL(plan.error().text());
    CHECK(plan->transit.start().isApprox(tests::home_rad(), 1e-9));
    CHECK(plan->transit.goal().isApprox(plan->reach.pre_grasp_rad, 1e-9));
    CHECK(plan->approach.start().isApprox(plan->reach.pre_grasp_rad, 1e-9));
    CHECK(plan->approach.goal().isApprox(plan->reach.grasp_rad, 1e-9));
    CHECK(plan->retreat.goal().isApprox(plan->reach.pre_grasp_rad, 1e-9));
    CHECK(plan->home.goal().isApprox(tests::home_rad(), 1e-9));
    CHECK(plan->states_checked > 0);

    const hal::Pose X_WH = planner::hand_pose(grasp, planner::HandModel{});
    CHECK(hal::hand_pose(robot, plan->reach.grasp_rad).isApprox(X_WH, 1e-6));
    hal::Pose lifted = X_WH;
    lifted.translation().z() += kLift;
    CHECK(hal::hand_pose(robot, plan->reach.lifted_rad).isApprox(lifted, 1e-6));

    double aside = 0.0, turned = 0.0;
    for (double t = 0.0; t <= plan->approach.duration_s(); t += 0.02) {
      const hal::Pose at = hal::hand_pose(robot, plan->approach.sample(t).q_rad);
      const Vec3 off = X_WH.linear().transpose() * (at.translation() - X_WH.translation());
      aside = std::max(aside, off.head<2>().norm());
      turned = std::max(turned, (at.linear() - X_WH.linear()).norm());
      CHECK(off.z() < 1e-6);
      CHECK(off.z() > -config.pre_grasp_m - 1e-6);
    }
    CHECK(aside < 0.001);
    CHECK(turned < 0.01);

    CHECK(planner::palm_speed_m_s(robot, plan->transit) <= config.transit_speed_m_s);
    CHECK(planner::palm_speed_m_s(robot, plan->approach) <= config.approach_speed_m_s);
    check_limits(plan->transit, config);
    check_limits(plan->approach, config);
    CHECK(deepest(plan->transit, world.truth) == 0.0);
    CHECK(deepest(plan->approach, world.truth, Label::Target) == 0.0);
  }
}

TEST_CASE("same seed, same plan, bit for bit; whatever was planned before") {
  TableAt table;
  table.yaw_rad = 0.4;
  const auto world = tests::see_from_all_sides(one_table(table));
  const auto grasp = tests::plate_grasp(table, kSideNear, 0.1);
  MotionPlanner first = planner_in(world), second = planner_in(world);
  const auto other = second.plan(tests::home_rad(), tests::plate_grasp(table, kSideNear, -0.2), kLift);
  static_cast<void>(other);
  const auto a = first.plan(tests::home_rad(), grasp, kLift),
             b = second.plan(tests::home_rad(), grasp, kLift);
  REQUIRE(a);
  REQUIRE(b);
  REQUIRE(a->transit.duration_s() == b->transit.duration_s());
  for (double t = 0.0; t < a->transit.duration_s(); t += 0.05) {
    REQUIRE(a->transit.sample(t).q_rad == b->transit.sample(t).q_rad);
    REQUIRE(a->transit.sample(t).dq_rad_s == b->transit.sample(t).dq_rad_s);
  }
}

TEST_CASE("a grasp beyond the arm's reach is refused with the distance that is missing") {
  const auto world = tests::see_from_all_sides(one_table({}));
  MotionPlanner planner = planner_in(world);
  const auto grasp = tests::grasp_at({1.2, 0.3, 0.4}, Vec3::UnitX(), Vec3::UnitZ(), 0.025);
  const auto reach = planner.reach(grasp, kLift);
  REQUIRE_FALSE(reach);
  // palm 30 mm before the face, wrist 137 mm behind the palm, shoulder at 310.5 mm, both links 790 mm
  const double missing = (Vec3(1.2 - 0.167, 0.3, 0.4) - Vec3(0, 0, 0.3105)).norm() - 0.79;
  CHECK_THAT(reach.error(),
             Catch::Contains(std::to_string(std::lround(1000 * missing)) + " mm beyond the arm's reach"));
  const auto plan = planner.plan(tests::home_rad(), grasp, kLift);
  REQUIRE_FALSE(plan);
  CHECK(plan.error().code == hal::ErrorCode::NotFound);
  CHECK(plan.error().where == "plan.reach");
}

TEST_CASE("a grasp whose lift would end beyond the arm's reach is refused for the lift") {
  const auto world = tests::see_from_all_sides(one_table({}));
  MotionPlanner planner = planner_in(world);
  // the wrist just reaches it, 8 cm higher it no longer does
  const double z = 0.75, x = std::sqrt(0.785 * 0.785 - (z - 0.3105) * (z - 0.3105)) + 0.167;
  const auto reach = planner.reach(tests::grasp_at({x, 0.0, z}, Vec3::UnitX(), Vec3::UnitZ(), 0.025), kLift);
  REQUIRE_FALSE(reach);
  CHECK_THAT(reach.error(), Catch::Contains("lift"));
}

TEST_CASE("a grasp behind an obstacle is refused, and the words say what is met where") {
  TableAt table;
  sim_hal::World truth = one_table(table);
  // a screen right before the near edge
  truth.shapes.push_back(sim_hal::box({0.62, 0.0, 0.5}, {0.03, 1.0, 1.0}, 0.0, Label::Clutter));
  const auto world = tests::see_from_all_sides(truth);
  MotionPlanner planner = planner_in(world);
  std::vector<planner::GraspCandidate> candidates{
      tests::plate_grasp(table, kSideNear, 0.0),
      tests::grasp_at({2, 0, 0.4}, Vec3::UnitX(), Vec3::UnitZ(), 0.02),
      tests::plate_grasp(table, kSideNear, 0.1)};
  candidates[2].verdict = planner::Verdict::Collision;
  candidates[2].reason = "known before";
  planner.judge(candidates, kLift);
  CHECK(candidates[0].verdict == planner::Verdict::Unreachable);
  CHECK_THAT(candidates[0].reason, Catch::Contains("obstacle") && Catch::Contains("mm"));
  REQUIRE(candidates[0].miss_m);
  CHECK(*candidates[0].miss_m > 0.0);
  CHECK(candidates[1].verdict == planner::Verdict::Unreachable);
  CHECK_THAT(candidates[1].reason, Catch::Contains("beyond the arm's reach"));
  CHECK(candidates[2].reason == "known before");
}

TEST_CASE("nothing is planned from a start that touches something or lies beyond the limits") {
  const TableAt table;
  const auto world = tests::see_from_all_sides(one_table(table));
  MotionPlanner planner = planner_in(world);
  const auto grasp = tests::plate_grasp(table, kSideNear, 0.0);
  JointVector low = JointVector::Zero();
  low[1] = -1.9;  // hand in the floor or the table
  const auto touching = planner.plan(low, grasp, kLift);
  REQUIRE_FALSE(touching);
  CHECK(touching.error().where == "plan.start");
  JointVector beyond = tests::home_rad();
  beyond[3] = 2.5;
  const auto outside = planner.plan_to(beyond, tests::home_rad());
  REQUIRE_FALSE(outside);
  CHECK(outside.error().where == "plan.start");
  CHECK_THAT(outside.error().detail, Catch::Contains("A4"));
  JointVector unset = tests::home_rad();
  unset[2] = std::nan("");
  CHECK(planner.plan_to(unset, tests::home_rad()).error().code == hal::ErrorCode::BadInput);
}

TEST_CASE("without a collision world nothing is planned") {
  MotionPlanner planner(hal::built_in_robot(), planner::HandModel{}, {}, 1);
  const auto plan = planner.plan_to(tests::home_rad(), tests::home_rad());
  REQUIRE_FALSE(plan);
  CHECK(plan.error().code == hal::ErrorCode::NotReady);
  CHECK_FALSE(planner.reach(tests::plate_grasp({}, kSideNear, 0.0), kLift));
}
