#include <catch2/catch.hpp>
#include <kdl/chainfksolverpos_recursive.hpp>
#include <kdl/chainjnttojacsolver.hpp>
#include <kdl/jacobian.hpp>

#include "kdl_chain.hpp"
#include "planner/motion/inverse_kinematics/arm_ik.hpp"
#include "planner/motion/joint_random.hpp"

using namespace colift;
using hal::JointVector;
using hal::Pose;

namespace {

const planner::ArmGeometry& arm() {
  static const planner::ArmGeometry geometry = planner::arm_geometry(hal::built_in_robot()).value();
  return geometry;
}

class Kdl {
 public:
  Pose flange(const JointVector& q_rad) {
    KDL::Frame frame;
    REQUIRE(solver_.JntToCart(test::to_kdl(q_rad), frame) >= 0);
    return test::from_kdl(frame);
  }

 private:
  KDL::Chain chain_ = test::lwr_chain();
  KDL::ChainFkSolverPos_recursive solver_{chain_};
};

double difference(const Pose& a, const Pose& b) {
  return (a.matrix() - b.matrix()).cwiseAbs().maxCoeff();
}

}  // namespace

TEST_CASE("KDL puts the flange where the robot model and the geometry put it") {
  Kdl kdl;
  planner::JointRandom random(1);
  const hal::RobotModel& robot = hal::built_in_robot();
  for (int i = 0; i < 5000; ++i) {
    const JointVector q = random.in({arm().lower_rad, arm().upper_rad});
    const Pose X_WF = kdl.flange(q);
    REQUIRE(difference(planner::flange_pose(arm(), q), X_WF) < 1e-9);
    REQUIRE(difference(hal::hand_pose(robot, q) * robot.X_FH.inverse(), X_WF) < 1e-9);
  }
}

TEST_CASE("KDL agrees with the Jacobian") {
  const KDL::Chain chain = test::lwr_chain();
  KDL::ChainJntToJacSolver solver(chain);
  planner::JointRandom random(2);
  const hal::RobotModel& robot = hal::built_in_robot();
  const hal::Vec3 flange_H = robot.X_FH.inverse().translation();
  KDL::Jacobian jacobian(hal::kArmJoints);
  for (int i = 0; i < 1000; ++i) {
    const JointVector q = random.in({arm().lower_rad, arm().upper_rad});
    REQUIRE(solver.JntToJac(test::to_kdl(q), jacobian) >= 0);
    const hal::ArmJacobian J = hal::jacobian(robot, q, flange_H);
    REQUIRE((J - jacobian.data).cwiseAbs().maxCoeff() < 1e-9);
  }
}

TEST_CASE("by KDL's kinematics every solution of the closed form puts the flange where it was asked") {
  Kdl kdl;
  planner::JointRandom random(3);
  std::size_t solutions = 0;
  for (int i = 0; i < 500; ++i) {
    const Pose X_WF = kdl.flange(random.in({arm().lower_rad, arm().upper_rad}));
    const auto all = planner::all_ik(arm(), X_WF, 0.0);
    REQUIRE_FALSE(all.empty());
    for (const auto& ik : all) REQUIRE(difference(kdl.flange(ik.q_rad), X_WF) < 1e-9);
    solutions += all.size();
  }
  CHECK(solutions > 5000);
}
