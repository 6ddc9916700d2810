#include <catch2/catch.hpp>
#include <kdl/chaindynparam.hpp>
#include <kdl/chainidsolver_recursive_newton_euler.hpp>

#include "hal/robot_model/dynamics.hpp"
#include "kdl_chain.hpp"
#include "planner/motion/joint_random.hpp"

using namespace colift;
using hal::JointVector;

namespace {

/// The arm of our URDF as KDL sees it: bodies link by link, joints about their own axes.
KDL::Chain chain_with_masses(const hal::RobotModel& robot) {
  KDL::Chain chain;
  for (const int link : robot.arm) {
    const hal::RobotLink& l = robot.links[static_cast<std::size_t>(link)];
    chain.addSegment(KDL::Segment(KDL::Joint(KDL::Joint::None), test::to_kdl(l.X_PL0)));
    const auto& I = l.inertia;
    const KDL::RigidBodyInertia body(
        l.mass_kg, KDL::Vector(l.com_m.x(), l.com_m.y(), l.com_m.z()),
        KDL::RotationalInertia(I(0, 0), I(1, 1), I(2, 2), I(0, 1), I(0, 2), I(1, 2)));
    chain.addSegment(KDL::Segment(
        KDL::Joint(KDL::Vector::Zero(), KDL::Vector(l.axis.x(), l.axis.y(), l.axis.z()), KDL::Joint::RotAxis),
        KDL::Frame::Identity(), body));
  }
  return chain;
}

}  // namespace

TEST_CASE("KDL agrees with gravity, mass matrix and torque of a motion") {
  const hal::RobotModel& robot = hal::built_in_robot();
  const hal::ArmDynamics arm(robot, hal::ArmDynamics::Load::Bare);
  const KDL::Chain chain = chain_with_masses(robot);
  const KDL::Vector down(0.0, 0.0, -hal::kGravity_m_s2);
  KDL::ChainDynParam parameters(chain, down);
  KDL::ChainIdSolver_RNE recursion(chain, down);
  planner::JointRandom random(4);
  for (int n = 0; n < 500; ++n) {
    const JointVector q = random.in({robot.lower_rad(), robot.upper_rad()});
    const JointVector dq = random.in({robot.lower_rad(), robot.upper_rad()});
    const JointVector ddq = random.in({robot.lower_rad(), robot.upper_rad()});
    KDL::JntArray g(7), tau(7);
    KDL::JntSpaceInertiaMatrix M(7);
    REQUIRE(parameters.JntToGravity(test::to_kdl(q), g) >= 0);
    REQUIRE(parameters.JntToMass(test::to_kdl(q), M) >= 0);
    REQUIRE(recursion.CartToJnt(test::to_kdl(q), test::to_kdl(dq), test::to_kdl(ddq),
                                KDL::Wrenches(chain.getNrOfSegments()), tau) >= 0);
    REQUIRE((arm.gravity_nm(q) - g.data).cwiseAbs().maxCoeff() < 1e-9);
    REQUIRE((arm.mass_matrix(q) - M.data).cwiseAbs().maxCoeff() < 1e-9);
    REQUIRE((arm.torque_nm(q, dq, ddq) - tau.data).cwiseAbs().maxCoeff() < 1e-9);
  }
}
