#include "hal/robot_model/dynamics.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "planner/motion/joint_random.hpp"

using namespace colift;
using hal::ArmDynamics;
using hal::JointMatrix;
using hal::JointVector;

namespace {

constexpr double kPi = std::numbers::pi;

JointVector joints(std::array<double, 7> q) {
  return JointVector(q.data());
}

const ArmDynamics& bare() {
  static const ArmDynamics arm(hal::built_in_robot(), ArmDynamics::Load::Bare);
  return arm;
}

const ArmDynamics& with_hand() {
  static const ArmDynamics arm(hal::built_in_robot(), ArmDynamics::Load::Hand);
  return arm;
}

JointVector random_pose(planner::JointRandom& random) {
  return random.in({hal::built_in_robot().lower_rad(), hal::built_in_robot().upper_rad()});
}

}  // namespace

// The figures are KDL's for the masses of ISIR's public model; ours have inertias rounded to four digits.
TEST_CASE("the bare arm weighs what the public model weighs", "[dynamics]") {
  const JointVector forwards = bare().gravity_nm(joints({0, kPi / 2, 0, 0, 0, 0, 0}));
  CHECK(forwards[1] == Approx(-42.44).margin(0.01));
  CHECK(forwards[3] == Approx(12.18).margin(0.01));
  const JointVector bent = bare().gravity_nm(joints({0, kPi / 6, 0, -kPi / 2, 0, kPi / 3, 0}));
  CHECK(bent[1] == Approx(-25.66).margin(0.01));
  CHECK(bent[3] == Approx(10.53).margin(0.01));
  CHECK(bare().mass_matrix(joints({0, kPi / 2, 0, 0, 0, 0, 0}))(0, 0) == Approx(2.557).margin(0.003));

  const JointVector q = joints({0.1, 0.5, -0.3, -1.2, 0.4, 0.8, -0.6});
  const JointVector g = joints({0, -26.001, -1.817, 11.960, -0.246, -0.014, 0});
  CHECK((bare().gravity_nm(q) - g).cwiseAbs().maxCoeff() < 0.005);
  const JointVector m = joints({1.132, 1.866, 0.365, 0.407, 0.0077, 0.0035, 0.0001});
  CHECK((bare().mass_matrix(q).diagonal() - m).cwiseAbs().maxCoeff() < 0.002);
}

TEST_CASE("nothing can be held up by A1, and a hand weighs on every joint that lifts it", "[dynamics]") {
  planner::JointRandom random(1);
  for (int i = 0; i < 100; ++i) CHECK(std::abs(with_hand().gravity_nm(random_pose(random))[0]) < 1e-9);
  const JointVector forwards = joints({0, kPi / 2, 0, 0, 0, 0, 0});
  const double more = with_hand().gravity_nm(forwards)[1] - bare().gravity_nm(forwards)[1];
  double hand_kg = 0.0;
  for (std::size_t i = 0; i < hal::built_in_robot().links.size(); ++i)
    if (hal::built_in_robot().in_hand(static_cast<int>(i))) hand_kg += hal::built_in_robot().links[i].mass_kg;
  // 0.868 m from the shoulder to the flange, and the hand's middle beyond it
  CHECK(-more / (hal::kGravity_m_s2 * hand_kg) > 0.868);
  CHECK(-more / (hal::kGravity_m_s2 * hand_kg) < 0.868 + 0.12);
}

TEST_CASE("the mass matrix is what the recursion says of single accelerations", "[dynamics]") {
  planner::JointRandom random(2);
  for (int n = 0; n < 200; ++n) {
    const JointVector q = random_pose(random), zero = JointVector::Zero();
    const JointMatrix M = with_hand().mass_matrix(q);
    const JointVector g = with_hand().gravity_nm(q);
    for (int i = 0; i < hal::kArmJoints; ++i) {
      const JointVector column = with_hand().torque_nm(q, zero, JointVector::Unit(i)) - g;
      REQUIRE((M.col(i) - column).cwiseAbs().maxCoeff() < 1e-12);
    }
    REQUIRE((M - M.transpose()).cwiseAbs().maxCoeff() == 0.0);
    REQUIRE(M.llt().info() == Eigen::Success);
  }
}

TEST_CASE("what the joints do to the arm is found in its energy", "[dynamics]") {
  // d/dt (1/2 dq' M dq) = dq' (tau - g) for any motion, and dV/dt = dq' g: no term of the recursion may be
  // off
  planner::JointRandom random(3);
  for (int n = 0; n < 200; ++n) {
    const JointVector q = random_pose(random);
    const JointVector dq = 0.3 * random_pose(random), ddq = random_pose(random);
    const double h = 1e-5;
    const auto kinetic = [&](double t) -> double {
      const JointVector v = dq + t * ddq;
      return 0.5 * v.dot(with_hand().mass_matrix(q + t * dq + 0.5 * t * t * ddq) * v);
    };
    const double power = dq.dot(with_hand().torque_nm(q, dq, ddq) - with_hand().gravity_nm(q));
    REQUIRE((kinetic(h) - kinetic(-h)) / (2.0 * h) == Approx(power).margin(1e-5));
  }
}

TEST_CASE("flange and Jacobian are the robot model's", "[dynamics]") {
  planner::JointRandom random(4);
  const hal::RobotModel& robot = hal::built_in_robot();
  const hal::Vec3 p_F(0.01, -0.02, 0.1);
  const hal::Vec3 p_H = robot.X_FH.inverse() * p_F;
  for (int n = 0; n < 100; ++n) {
    const JointVector q = random_pose(random);
    const hal::Pose X_WF = hal::hand_pose(robot, q) * robot.X_FH.inverse();
    REQUIRE((bare().flange(q).matrix() - X_WF.matrix()).cwiseAbs().maxCoeff() < 1e-12);
    REQUIRE((bare().jacobian(q, p_F) - hal::jacobian(robot, q, p_H)).cwiseAbs().maxCoeff() < 1e-12);
  }
  const hal::Pose X = bare().flange(joints({0.1, 0.5, -0.3, -1.2, 0.4, 0.8, -0.6}));
  CHECK((X.translation() - hal::Vec3(-0.622077, 0.045213, 0.559355)).norm() < 2e-6);
}

TEST_CASE("one walk along the arm tells what three tell", "[dynamics]") {
  planner::JointRandom random(9);
  const hal::Vec3 p_F(0.02, -0.03, 0.1);
  for (const ArmDynamics* arm : {&bare(), &with_hand()}) {
    for (int n = 0; n < 200; ++n) {
      const JointVector q = random_pose(random);
      const ArmDynamics::Tick tick = arm->tick(q, p_F);
      REQUIRE((tick.X_WF.matrix() - arm->flange(q).matrix()).cwiseAbs().maxCoeff() < 1e-12);
      REQUIRE((tick.jacobian - arm->jacobian(q, p_F)).cwiseAbs().maxCoeff() < 1e-12);
      REQUIRE((tick.gravity_nm - arm->gravity_nm(q)).cwiseAbs().maxCoeff() < 1e-10);
    }
  }
}
