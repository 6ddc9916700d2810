#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <random>

#include "hal/robot_model/robot_model.hpp"

using namespace colift::hal;

namespace {

JointVector joints(std::initializer_list<double> values) {
  JointVector q = JointVector::Zero();
  int i = 0;
  for (const double v : values) q[i++] = v;
  return q;
}

JointVector random_joints(std::mt19937_64& engine, const RobotModel& robot) {
  JointVector q;
  for (int i = 0; i < kArmJoints; ++i) {
    const double unit = static_cast<double>(engine() >> 11) * 0x1p-53;
    q[i] = robot.lower_rad()[i] + unit * (robot.upper_rad()[i] - robot.lower_rad()[i]);
  }
  return q;
}

Pose flange_pose(const RobotModel& robot, const JointVector& q) {
  std::vector<Pose> X_WL;
  link_poses(robot, q, HandPosture{}, X_WL);
  return X_WL[static_cast<std::size_t>(robot.flange)];
}

/// The arm once more, by the standard Denavit-Hartenberg table that public descriptions of the LWR give.
Pose by_denavit_hartenberg(const JointVector& q) {
  const double alpha[] = {90, -90, -90, 90, 90, -90, 0};
  const double d[] = {0.3105, 0, 0.400, 0, 0.390, 0, 0.078};
  Pose X = Pose::Identity();
  for (int i = 0; i < kArmJoints; ++i) {
    X = X * Eigen::AngleAxisd(q[i], Vec3::UnitZ()) * Eigen::Translation3d(0, 0, d[i]) *
        Eigen::AngleAxisd(alpha[i] * std::numbers::pi / 180.0, Vec3::UnitX());
  }
  return X;
}

}  // namespace

TEST_CASE("the flange stands where public models of the LWR put it") {
  const RobotModel& robot = built_in_robot();
  const double right = std::numbers::pi / 2;
  const Pose zero = flange_pose(robot, JointVector::Zero());
  CHECK((zero.translation() - Vec3(0, 0, 1.1785)).norm() < 1e-12);
  CHECK(zero.linear().isIdentity(1e-12));

  const Pose bent = flange_pose(robot, joints({0, right}));
  CHECK((bent.translation() - Vec3(-0.868, 0, 0.3105)).norm() < 1e-12);
  Eigen::Matrix3d R;
  R << 0, 0, -1, 0, 1, 0, 1, 0, 0;
  CHECK(bent.linear().isApprox(R, 1e-12));

  const Pose elbow = flange_pose(robot, joints({0.3, 0, 0, right}));
  CHECK((elbow.translation() - Vec3(0.447097, 0.138303, 0.7105)).cwiseAbs().maxCoeff() < 1e-6);

  const Pose any = flange_pose(robot, joints({0.1, 0.5, -0.3, -1.2, 0.4, 0.8, -0.6}));
  CHECK((any.translation() - Vec3(-0.622077, 0.045213, 0.559355)).cwiseAbs().maxCoeff() < 1e-6);
  R << -0.725793, -0.252888, -0.639744, -0.273934, 0.959311, -0.068433, 0.631019, 0.125579, -0.765536;
  CHECK((any.linear() - R).cwiseAbs().maxCoeff() < 2e-6);
}

TEST_CASE("the arm agrees with its Denavit-Hartenberg table everywhere") {
  const RobotModel& robot = built_in_robot();
  std::mt19937_64 engine(3);
  for (int i = 0; i < 2000; ++i) {
    const JointVector q = random_joints(engine, robot);
    REQUIRE((flange_pose(robot, q).matrix() - by_denavit_hartenberg(q).matrix()).cwiseAbs().maxCoeff() <
            1e-12);
    REQUIRE(
        (hand_pose(robot, q).matrix() - (flange_pose(robot, q) * robot.X_FH).matrix()).cwiseAbs().maxCoeff() <
        1e-12);
  }
}

TEST_CASE("the palm is 137.1 mm from the middle of the wrist and looks along the flange") {
  const RobotModel& robot = built_in_robot();
  CHECK(robot.X_FH.linear().isIdentity(1e-15));
  CHECK((robot.X_FH.translation() - Vec3(0, 0, 0.0591)).norm() < 1e-15);
  std::vector<Pose> X_WL;
  link_poses(robot, joints({0.4, -0.7, 0.2, 1.1, -0.3, 0.9, 0.5}), HandPosture{}, X_WL);
  const Vec3 wrist = X_WL[static_cast<std::size_t>(robot.arm[5])].translation();
  const Vec3 palm = X_WL[static_cast<std::size_t>(robot.palm)].translation();
  CHECK((palm - wrist).norm() == Approx(0.1371).margin(1e-12));
}

TEST_CASE("the Jacobian is the derivative of the pose") {
  const RobotModel& robot = built_in_robot();
  std::mt19937_64 engine(5);
  const Vec3 p_H(0.02, -0.03, 0.08);
  constexpr double h = 1e-6;
  for (int n = 0; n < 200; ++n) {
    const JointVector q = random_joints(engine, robot);
    const ArmJacobian J = jacobian(robot, q, p_H);
    for (int i = 0; i < kArmJoints; ++i) {
      const JointVector step = h * JointVector::Unit(i);
      const Pose a = hand_pose(robot, q - step), b = hand_pose(robot, q + step);
      const Vec3 linear = (b * p_H - a * p_H) / (2 * h);
      const Eigen::Matrix3d W =
          (b.linear() - a.linear()) / (2 * h) * hand_pose(robot, q).linear().transpose();
      const Vec3 angular(W(2, 1), W(0, 2), W(1, 0));
      REQUIRE((J.col(i).head<3>() - linear).norm() < 1e-8);
      REQUIRE((J.col(i).tail<3>() - angular).norm() < 1e-8);
    }
  }
}

TEST_CASE("limits are those of the data sheet") {
  const RobotModel& robot = built_in_robot();
  const double degree = std::numbers::pi / 180.0;
  CHECK((robot.upper_rad() - degree * joints({170, 120, 170, 120, 170, 120, 170})).norm() < 1e-12);
  CHECK((robot.lower_rad() + robot.upper_rad()).norm() < 1e-12);
  CHECK((robot.velocity_rad_s() - degree * joints({110, 110, 128, 128, 204, 184, 184})).norm() < 1e-12);
  CHECK((robot.effort_nm() - joints({176, 176, 100, 100, 100, 38, 38})).norm() < 1e-12);
}

TEST_CASE("arm and hand weigh what their sources say") {
  const RobotModel& robot = built_in_robot();
  double arm = 0.0, hand = 0.0;
  for (std::size_t i = 0; i < robot.links.size(); ++i) {
    (robot.in_hand(static_cast<int>(i)) ? hand : arm) += robot.links[i].mass_kg;
  }
  CHECK(arm == Approx(13.63).margin(0.01));
  CHECK(hand == Approx(0.98).margin(0.001));
}

TEST_CASE("gravity torques are those of the model that the inertias come from") {
  // reference values were computed with KDL from ISIR's table, bare flange, g = 9.81
  const RobotModel& robot = built_in_robot();
  const auto gravity = [&](const JointVector& q) {
    std::vector<Pose> X_WL;
    link_poses(robot, q, HandPosture{}, X_WL);
    JointVector torque = JointVector::Zero();
    for (std::size_t i = 0; i < robot.links.size(); ++i) {
      if (robot.in_hand(static_cast<int>(i))) continue;
      const Vec3 com_W = X_WL[i] * robot.links[i].com_m;
      for (std::size_t j = 0; j < kArmJoints; ++j) {
        const auto joint = static_cast<std::size_t>(robot.arm[j]);
        if (joint > i) break;
        const Vec3 axis_W = X_WL[joint].linear() * robot.links[joint].axis;
        const Vec3 dp = axis_W.cross(com_W - X_WL[joint].translation());
        torque[static_cast<int>(j)] += 9.81 * robot.links[i].mass_kg * dp.z();
      }
    }
    return torque;
  };
  const JointVector any = gravity(joints({0.1, 0.5, -0.3, -1.2, 0.4, 0.8, -0.6}));
  CHECK((any - joints({0, -26.001, -1.817, 11.960, -0.246, -0.014, 0})).cwiseAbs().maxCoeff() < 0.002);
  const JointVector out = gravity(joints({0, std::numbers::pi / 2}));
  CHECK(out[1] == Approx(-42.44).margin(0.01));
  CHECK(out[3] == Approx(12.18).margin(0.01));
}

TEST_CASE("only neighbours of the stretched arm's shapes touch") {
  // bounding spheres along the links are too coarse here; the cylinders' ends are what counts
  const RobotModel& robot = built_in_robot();
  std::vector<Pose> X_WL;
  link_poses(robot, JointVector::Zero(), HandPosture{}, X_WL);
  std::vector<std::pair<double, double>> spans;  // along z: the arm is straight
  for (std::size_t i = 0; i < robot.links.size() && !robot.in_hand(static_cast<int>(i)); ++i) {
    double low = 1e9, high = -1e9;
    for (const LinkShape& s : robot.links[i].shapes) {
      const double z = (X_WL[i] * s.X_LS).translation().z();
      const double half = s.kind == LinkShape::Kind::Cylinder ? 0.5 * s.size[1] : s.size[0];
      low = std::min(low, z - half);
      high = std::max(high, z + half);
    }
    if (low < high) spans.emplace_back(low, high);
  }
  REQUIRE(spans.size() == 8);
  for (std::size_t i = 0; i + 2 < spans.size(); ++i) CHECK(spans[i].second < spans[i + 2].first);
  for (std::size_t i = 0; i + 1 < spans.size(); ++i) CHECK(spans[i].second > spans[i + 1].first - 1e-9);
}
