#include "planner/motion/inverse_kinematics/arm_ik.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <numbers>

#include "planner/motion/joint_random.hpp"

using namespace colift;
using hal::JointVector;
using hal::Pose;
using hal::Vec3;
using planner::IkSolution;

namespace {

constexpr double kPi = std::numbers::pi;

const planner::ArmGeometry& arm() {
  static const planner::ArmGeometry geometry = planner::arm_geometry(hal::built_in_robot()).value();
  return geometry;
}

planner::JointBox limits(double margin = 0.0) {
  const JointVector m = JointVector::Constant(margin);
  return {arm().lower_rad + m, arm().upper_rad - m};
}

/// The flange by the robot model's own kinematics, which is tested against Denavit-Hartenberg tables.
Pose flange(const JointVector& q) {
  return hal::hand_pose(hal::built_in_robot(), q) * hal::built_in_robot().X_FH.inverse();
}

/// Largest difference of position (m) and of rotation matrix.
double error(const JointVector& q, const Pose& X_WF) {
  return (flange(q).matrix() - X_WF.matrix()).cwiseAbs().maxCoeff();
}

JointVector joints(std::initializer_list<double> values) {
  JointVector q = JointVector::Zero();
  int i = 0;
  for (const double v : values) q[i++] = v;
  return q;
}

}  // namespace

TEST_CASE("the geometry is read from the robot model") {
  CHECK(arm().base_to_shoulder_m == Approx(0.3105));
  CHECK(arm().upper_arm_m == Approx(0.40));
  CHECK(arm().forearm_m == Approx(0.39));
  CHECK(arm().wrist_to_flange_m == Approx(0.078));
  planner::JointRandom random(1);
  for (int i = 0; i < 1000; ++i) {
    const JointVector q = random.in(limits());
    REQUIRE(error(q, planner::flange_pose(arm(), q)) < 1e-12);
  }
}

TEST_CASE("an arm with other axes is refused") {
  hal::RobotModel other = hal::built_in_robot();
  other.links[static_cast<std::size_t>(other.arm[3])].axis = -Vec3::UnitY();
  const auto geometry = planner::arm_geometry(other);
  REQUIRE_FALSE(geometry);
  CHECK(geometry.error().code == hal::ErrorCode::BadConfig);
  CHECK_THAT(geometry.error().detail, Catch::Matchers::Contains("arm_4"));

  hal::RobotModel bent = hal::built_in_robot();
  bent.links[static_cast<std::size_t>(bent.arm[4])].X_PL0.translation().x() += 0.01;
  CHECK_FALSE(planner::arm_geometry(bent));
}

TEST_CASE("every pose that the arm can take has solutions, all exact and within the limits") {
  planner::JointRandom random(7);
  for (int i = 0; i < 20000; ++i) {
    const JointVector q = random.in(limits());
    const Pose X_WF = flange(q);
    const auto all = planner::all_ik(arm(), X_WF, 0.0);
    CAPTURE(i, q.transpose());
    REQUIRE_FALSE(all.empty());
    double last = 1.0;
    for (const auto& ik : all) {
      REQUIRE(error(ik.q_rad, X_WF) < 1e-9);
      REQUIRE(limits().contains(ik.q_rad));
      REQUIRE(ik.score <= last);
      REQUIRE(ik.score >= 0.0);
      last = ik.score;
    }
  }
}

TEST_CASE("a coarse grid of elbow angles misses no pose either") {
  // near the limits in all joints the free intervals of the elbow are narrow: few grid points, all poses
  planner::JointRandom random(8);
  for (int i = 0; i < 20000; ++i) {
    JointVector q;
    for (int j = 0; j < 7; ++j) {
      const double room = random.between(0.0, 1.0);
      q[j] = random.unit() < 0.5 ? arm().lower_rad[j] + 0.02 * room : arm().upper_rad[j] - 0.02 * room;
    }
    const Pose X_WF = flange(q);
    const auto all = planner::all_ik(arm(), X_WF, 0.0, 3);
    CAPTURE(i, q.transpose());
    REQUIRE_FALSE(all.empty());
    REQUIRE(error(all.front().q_rad, X_WF) < 1e-9);
    REQUIRE(limits().contains(all.front().q_rad));
  }
}

TEST_CASE("at its own elbow angle a joint position is found again on its own branch") {
  planner::JointRandom random(9);
  std::array<IkSolution, 8> out;
  for (int i = 0; i < 20000; ++i) {
    const JointVector q = random.in(limits());
    const double elbow = planner::elbow_angle(arm(), q);
    const int count = planner::solve_ik(arm(), flange(q), elbow, 0.0, out);
    const int branch = (q[1] < 0 ? 1 : 0) | (q[3] < 0 ? 2 : 0) | (q[5] < 0 ? 4 : 0);
    bool found = false;
    for (int k = 0; k < count; ++k) {
      const IkSolution& ik = out[static_cast<std::size_t>(k)];
      if (ik.branch != branch) continue;
      found = true;
      // joints are badly conditioned near singular positions, poses are not
      const double singular = std::min({std::abs(q[1]), std::abs(q[3]), std::abs(q[5])});
      CAPTURE(i, q.transpose(), ik.q_rad.transpose());
      REQUIRE((ik.q_rad - q).cwiseAbs().maxCoeff() < 1e-11 / (singular * singular));
    }
    REQUIRE(found);
  }
}

TEST_CASE("away from limits there are eight solutions, all different, with the elbow where it was asked") {
  planner::ArmGeometry free = arm();
  free.lower_rad.setConstant(-kPi);
  free.upper_rad.setConstant(kPi);
  planner::JointRandom random(10);
  std::array<IkSolution, 8> out;
  for (int i = 0; i < 2000; ++i) {
    const Pose X_WF = flange(random.in(limits()));
    const double elbow = random.between(-kPi, kPi);
    REQUIRE(planner::solve_ik(free, X_WF, elbow, 0.0, out) == 8);
    int branches = 0;
    for (const IkSolution& ik : out) {
      branches |= 1 << ik.branch;
      REQUIRE(error(ik.q_rad, X_WF) < 1e-9);
      const double off = std::remainder(planner::elbow_angle(free, ik.q_rad) - elbow, 2 * kPi);
      REQUIRE(std::abs(off) < 1e-6);
    }
    REQUIRE(branches == 0xff);
  }
}

TEST_CASE("elbow angle 0 has the elbow above the line from shoulder to wrist") {
  const Pose X_WF = flange(joints({0.3, -0.8, 0.4, 1.2, 0.2, -0.9, 0.1}));
  std::array<IkSolution, 8> out;
  planner::ArmGeometry free = arm();
  free.lower_rad.setConstant(-kPi);
  free.upper_rad.setConstant(kPi);
  const Vec3 shoulder(0, 0, arm().base_to_shoulder_m);
  const Vec3 wrist = X_WF * Vec3(0, 0, -arm().wrist_to_flange_m);
  for (const double elbow : {0.0, kPi}) {
    REQUIRE(planner::solve_ik(free, X_WF, elbow, 0.0, out) == 8);
    std::vector<Pose> X_WL;
    hal::link_poses(hal::built_in_robot(), out[0].q_rad, {}, X_WL);
    const Vec3 at = X_WL[static_cast<std::size_t>(hal::built_in_robot().arm[3])].translation();
    const Vec3 n = (wrist - shoulder).normalized();
    const Vec3 off = (at - shoulder) - n * n.dot(at - shoulder);
    CHECK(off.norm() > 0.05);
    CHECK((elbow == 0.0 ? off.z() : -off.z()) > 0.0);
    CHECK(std::abs(off.dot(n.cross(Vec3::UnitZ()))) < 1e-12);
  }
}

TEST_CASE("a margin keeps the joints away from their limits") {
  planner::JointRandom random(11);
  const double margin = 0.2;
  for (int i = 0; i < 2000; ++i) {
    const JointVector q = random.in(limits(margin));
    const auto all = planner::all_ik(arm(), flange(q), margin);
    REQUIRE_FALSE(all.empty());
    for (const auto& ik : all) REQUIRE(limits(margin).contains(ik.q_rad));
  }
  CHECK(planner::all_ik(arm(), flange(joints({0.5, 0.5, 0.5, 2.0, 0.5, 0.5, 0.5})), 0.3).empty());
}

TEST_CASE("singular positions are solved exactly and without NaN") {
  const std::vector<JointVector> singular{
      joints({}),                                       // straight up
      joints({0, 0, 0, 1.0, 0, 0, 0}),                  // shoulder and wrist
      joints({0.4, 0, 0.3, 1.0, 0.2, 0.5, 0}),          // shoulder
      joints({0.4, 0.7, 0.3, 0, 0.2, 0.5, 0.1}),        // elbow straight
      joints({0.4, 0.7, 0.3, 0, 0.2, 0, 0.1}),          // elbow and wrist
      joints({0.4, 0.7, 0.3, -1.0, 0.2, 0, 0.1}),       // wrist
      joints({0, 0.8, 0, -1.6, 0, 0.8, 0}),             // hand straight above the base, nearly vertical line
      joints({1e-12, 1e-12, -1e-12, 1e-12, 0, 1e-12}),  // nearly straight up
      joints({0.1, 1e-7, -0.2, 1e-7, 0.3, 1e-7, 0.4}),
      joints({0.1, 1e-9, -0.2, 1.0, 0.3, 1e-9, 0.4}),
  };
  for (const JointVector& q : singular) {
    CAPTURE(q.transpose());
    const Pose X_WF = flange(q);
    const auto all = planner::all_ik(arm(), X_WF, 0.0);
    CHECK_FALSE(all.empty());
    for (const auto& ik : all) {
      REQUIRE(ik.q_rad.allFinite());
      REQUIRE(error(ik.q_rad, X_WF) < 1e-9);
      REQUIRE(limits().contains(ik.q_rad));
    }
    // A4 is the square root of a length: below 1e-6 rad the pose does not tell where the elbow points
    const bool told = std::abs(q[3]) < 1e-11 || std::abs(q[3]) > 1e-6;
    const auto same = planner::follow_ik(arm(), X_WF, q, 0.0, 1e-3);
    CHECK((same || !told));
    if (same) CHECK(error(*same, X_WF) < 1e-9);
  }
}

TEST_CASE("a wrist straight above the shoulder can have its elbow anywhere") {
  // A2 and A4 such that the wrist is on the axis of A1
  const double bend = 1.4;
  const double lean = std::atan2(0.39 * std::sin(bend), 0.40 + 0.39 * std::cos(bend));
  const JointVector q = joints({0.3, lean, 0.0, bend, 0.2, 0.6, 0.1});
  const Pose X_WF = flange(q);
  std::array<IkSolution, 8> out;
  for (int i = 0; i < 12; ++i) {
    const int count = planner::solve_ik(arm(), X_WF, 0.5 * i - kPi, 0.0, out);
    for (int k = 0; k < count; ++k) REQUIRE(error(out[static_cast<std::size_t>(k)].q_rad, X_WF) < 1e-9);
  }
  CHECK_FALSE(planner::all_ik(arm(), X_WF, 0.0).empty());
}

TEST_CASE("what cannot be reached has no solution") {
  Pose far = Pose::Identity();
  far.translation() = Vec3(1.2, 0, 0.5);
  CHECK(planner::all_ik(arm(), far, 0.0).empty());
  Pose near = Pose::Identity();  // wrist in the shoulder
  near.translation() = Vec3(0, 0, 0.3105 + 0.078);
  CHECK(planner::all_ik(arm(), near, 0.0).empty());
  near.translation().z() += 0.2;  // nearer than the elbow bends
  CHECK(planner::all_ik(arm(), near, 0.0).empty());
  for (const double bad :
       {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    Pose wrong = flange(joints({0.1, 0.5, 0.3, 1.0}));
    wrong.translation().x() = bad;
    std::array<IkSolution, 8> out;
    CHECK(planner::all_ik(arm(), wrong, 0.0).empty());
    CHECK(planner::solve_ik(arm(), wrong, 0.3, 0.0, out) == 0);
    CHECK(planner::solve_ik(arm(), flange(joints({0.1, 0.5, 0.3, 1.0})), bad, 0.0, out) == 0);
    CHECK_FALSE(planner::follow_ik(arm(), wrong, JointVector::Zero(), 0.0, 1.0));
    CHECK_FALSE(planner::follow_ik(arm(), far, JointVector::Constant(bad), 0.0, 1.0));
  }
}

TEST_CASE("a pose that moves in small steps is followed in small steps") {
  planner::JointRandom random(12);
  int walks = 0;
  for (int i = 0; i < 300; ++i) {
    const JointVector start = random.in(limits(0.5));
    if (std::min({std::abs(start[1]), std::abs(start[3]), std::abs(start[5])}) < 0.4) continue;
    ++walks;
    Pose X_WF = flange(start);
    const Vec3 step =
        0.001 * Vec3(random.between(-1, 1), random.between(-1, 1), random.between(-1, 1)).normalized();
    JointVector q = start;
    for (int k = 0; k < 50; ++k) {
      X_WF.translation() += step;
      const auto next = planner::follow_ik(arm(), X_WF, q, 0.05, 0.1);
      if (!next) break;  // reach or limits end it
      REQUIRE(error(*next, X_WF) < 1e-9);
      REQUIRE((*next - q).cwiseAbs().maxCoeff() < 0.1);
      REQUIRE(limits(0.05).contains(*next));
      q = *next;
      if (k == 0) REQUIRE((*next - start).cwiseAbs().maxCoeff() < 0.02);
    }
  }
  CHECK(walks > 100);
}

TEST_CASE("following keeps the elbow angle as long as the limits let it") {
  const JointVector start = joints({0.2, -0.9, 0.3, 1.3, -0.2, -0.8, 0.4});
  Pose X_WF = flange(start);
  JointVector q = start;
  for (int k = 0; k < 100; ++k) {
    X_WF.translation().z() += 0.0005;
    const auto next = planner::follow_ik(arm(), X_WF, q, 0.01, 0.02);
    REQUIRE(next);
    q = *next;
  }
  CHECK(planner::elbow_angle(arm(), q) == Approx(planner::elbow_angle(arm(), start)).margin(1e-9));
}

TEST_CASE("at a limit the elbow gives way") {
  // A7 at its limit less a hair, flange turned further: only another elbow angle does it
  const JointVector start = joints({0.2, -0.9, 0.3, 1.3, -0.2, -0.8, arm().upper_rad[6] - 1e-4});
  Pose X_WF = flange(start);
  X_WF.linear() = (X_WF.linear() * Eigen::AngleAxisd(2e-3, Vec3::UnitZ())).eval();
  const auto next = planner::follow_ik(arm(), X_WF, start, 0.0, 0.05);
  REQUIRE(next);
  CHECK(limits().contains(*next));
  CHECK(error(*next, X_WF) < 1e-9);
  CHECK((*next - start).cwiseAbs().maxCoeff() < 0.02);
}

TEST_CASE("a jump is refused") {
  const JointVector start = joints({0.2, -0.9, 0.3, 1.3, -0.2, -0.8, 0.4});
  Pose X_WF = flange(start);
  X_WF.translation().x() += 0.1;
  CHECK_FALSE(planner::follow_ik(arm(), X_WF, start, 0.0, 0.01));
  CHECK(planner::follow_ik(arm(), X_WF, start, 0.0, 1.0));
}
