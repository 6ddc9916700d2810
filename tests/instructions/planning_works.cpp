// Collision scene, checks, inverse kinematics and a plan around a table with clutter.
#include <cmath>
#include <cstdlib>
#include <memory>
#include <numbers>

#include "counted_work.hpp"
#include "planner/motion/collision/fast_checker.hpp"
#include "planner/motion/inverse_kinematics/arm_ik.hpp"
#include "planner/motion/motion_planner.hpp"
#include "tests/unit/planner/motion/collision/collision_world.hpp"
#include "tests/unit/planner/motion/planning_world.hpp"

namespace colift::counted {
namespace {

constexpr int kStates = 2000, kPoses = 50, kPersonPoints = 20000;

/// A column of points, as a person's front is seen, beside the table.
std::vector<Eigen::Vector3f> person() {
  std::vector<Eigen::Vector3f> points;
  for (int i = 0; i < kPersonPoints; ++i) {
    const float turn = 0.618034F * static_cast<float>(i), z = 1.7F * static_cast<float>(i) / kPersonPoints;
    points.emplace_back(1.3F + 0.2F * std::cos(turn), 0.3F + 0.2F * std::sin(turn), z);
  }
  return points;
}

}  // namespace

std::vector<Work> planning_works() {
  std::vector<Work> works;
  works.push_back({"collision_scene", "distance fields of a map", [] {
                     auto world = std::make_shared<test::CollisionWorld>();
                     return [world] { (void)planner::make_collision_scene(world->map, world->ground, {}); };
                   }});
  works.push_back({"person_in_scene", "20 000 points of a person added to them, as before each plan", [] {
                     auto world = std::make_shared<test::CollisionWorld>();
                     auto scene = std::make_shared<planner::CollisionScene>(
                         planner::make_collision_scene(world->map, world->ground, {}));
                     return [world, scene, people = person()] {
                       (void)planner::with_partner(*scene, world->map.grid(), people);
                     };
                   }});
  works.push_back({"state_checks", "2000 joint positions against the scene", [] {
                     const test::CollisionWorld world;
                     const hal::RobotModel& robot = hal::built_in_robot();
                     auto checker = std::make_shared<planner::FastChecker>(
                         robot, planner::cover_with_spheres(robot), world.scene());
                     auto states = std::make_shared<std::vector<hal::JointVector>>();
                     test::NearTable near_table(22);
                     for (int i = 0; i < kStates; ++i) states->push_back(near_table.next());
                     return [checker, states] {
                       for (const hal::JointVector& q : *states) (void)checker->is_free(q);
                     };
                   }});
  works.push_back({"inverse_kinematics", "50 poses, all branches, 36 elbow angles", [] {
                     const auto arm = planner::arm_geometry(hal::built_in_robot());
                     if (!arm) std::abort();
                     std::vector<hal::Pose> poses;
                     sim_hal::Draws draws(5, 1);
                     for (int i = 0; i < kPoses; ++i)
                       poses.push_back(planner::flange_pose(*arm, test::draw_joints(draws)));
                     return [arm = *arm, poses] {
                       for (const hal::Pose& pose : poses) (void)planner::all_ik(arm, pose, 0.05, 36);
                     };
                   }});
  works.push_back({"plan", "a plan to the edge of a table, exact check included", [] {
                     sim_hal::World truth;
                     tests::add_floor(truth);
                     const tests::TableAt table;
                     tests::add_table(truth, table);
                     auto world = std::make_shared<tests::PlanningWorld>(tests::see_from_all_sides(truth));
                     auto planner = std::make_shared<planner::MotionPlanner>(
                         hal::built_in_robot(), planner::HandModel{}, planner::PlannerConfig{}, 1);
                     planner->set_scene(world->scene, world->map, hal::Vec3::UnitZ());
                     const auto grasp = tests::plate_grasp(table, std::numbers::pi, 0.0);
                     if (!planner->plan(tests::home_rad(), grasp, 0.1)) std::abort();
                     return [world, planner, grasp] { (void)planner->plan(tests::home_rad(), grasp, 0.1); };
                   }});
  return works;
}

}  // namespace colift::counted
