#include "control/lift/load_estimator.hpp"

#include <catch2/catch.hpp>
#include <limits>
#include <random>

#include "../allocations.hpp"

using namespace colift;
using namespace colift::control;
using hal::JointVector;
using hal::Vec3;

namespace {

/// Joint torques of a wrench on the palm by virtual work: what each joint's turning moves along the wrench.
/// Poses only, so that an error of the Jacobian would show.
JointVector torques_of(const JointVector& q, const hal::Wrench& F) {
  constexpr double kStep = 1e-6;
  JointVector tau;
  for (int i = 0; i < hal::kArmJoints; ++i) {
    JointVector ahead = q, behind = q;
    ahead[i] += kStep;
    behind[i] -= kStep;
    const hal::Pose a = hal::hand_pose(hal::built_in_robot(), ahead);
    const hal::Pose b = hal::hand_pose(hal::built_in_robot(), behind);
    const Eigen::AngleAxisd turned(a.linear() * b.linear().transpose());
    tau[i] = (F.force.dot(a.translation() - b.translation()) + F.torque.dot(turned.angle() * turned.axis())) /
             (2.0 * kStep);
  }
  return tau;
}

JointVector bent() {
  return (JointVector() << 0.3, 0.6, -0.2, -1.3, 0.4, 0.9, -0.5).finished();
}

const hal::RobotModel& built_in() {
  return hal::built_in_robot();
}

hal::Timestamp ms(int t) {
  return std::chrono::milliseconds(t);
}

}  // namespace

TEST_CASE("joint torques of a wrench give the wrench back", "[load]") {
  std::mt19937_64 bits(4);
  const auto draw = [&](double most) {
    return most * (2.0 * static_cast<double>(bits() >> 11) * 0x1p-53 - 1.0);
  };
  for (int i = 0; i < 200; ++i) {
    JointVector q = bent();
    for (int j = 0; j < hal::kArmJoints; ++j) q[j] += draw(0.4);
    const hal::Wrench F{Vec3(draw(50), draw(50), draw(50)), Vec3(draw(5), draw(5), draw(5))};
    const hal::Wrench seen = palm_wrench(built_in(), q, torques_of(q, F));
    CHECK((seen.force - F.force).norm() < 1e-4);
    CHECK((seen.torque - F.torque).norm() < 1e-4);
  }
}

TEST_CASE("a stretched arm feels less than there is, never wildly more", "[load]") {
  // elbow nearly straight: along the arm a force leaves the joints cold
  for (const double elbow : {0.0, 1e-9, 1e-6, 1e-3, 0.01, 0.03}) {
    JointVector q = bent();
    q[3] = -elbow;
    const hal::Wrench F{Vec3(0, 0, -30), Vec3::Zero()};
    JointVector tau = torques_of(q, F);
    for (int j = 0; j < hal::kArmJoints; ++j) tau[j] += j % 2 ? 0.2 : -0.2;  // what sensors make up
    const hal::Wrench seen = palm_wrench(built_in(), q, tau);
    CAPTURE(elbow);
    REQUIRE(seen.force.allFinite());
    CHECK(seen.force.norm() < 60.0);
  }
}

TEST_CASE("what was felt with an empty hand is nothing afterwards", "[load]") {
  LoadEstimator load(built_in(), LoadConfig{});
  const JointVector offset = (JointVector() << 1.0, -2.0, 0.5, 1.5, -0.3, 0.2, 0.1).finished();
  load.start_tare();
  for (int t = 1; t <= 100; ++t) {
    JointVector noise = JointVector::Constant(t % 2 ? 0.3 : -0.3);
    load.update(ms(t), bent(), offset + noise);
  }
  load.end_tare();
  const JointVector tau = torques_of(bent(), {Vec3(0, 0, -20), Vec3::Zero()});
  for (int t = 101; t <= 1100; ++t) load.update(ms(t), bent(), offset + tau);
  REQUIRE(load.wrench_W());
  CHECK(load.load_n() == Approx(20.0).margin(1e-3));
  CHECK(load.wrench_W()->force.head<2>().norm() < 1e-3);
}

TEST_CASE("a tare without any state changes nothing", "[load]") {
  LoadEstimator load(built_in(), LoadConfig{});
  load.start_tare();
  load.end_tare();
  CHECK_FALSE(load.wrench_W());
  CHECK(load.load_n() == 0.0);
  load.update(ms(1), bent(), torques_of(bent(), {Vec3(0, 0, -10), Vec3::Zero()}));
  CHECK(load.load_n() == Approx(10.0).margin(1e-4));
}

TEST_CASE("a sudden load is seen with the filter's time constant, whatever the cycle", "[load]") {
  for (const int cycle_ms : {1, 2, 5}) {
    LoadEstimator load(built_in(), LoadConfig{0.05});
    load.update(ms(0), bent(), JointVector::Zero());
    const JointVector tau = torques_of(bent(), {Vec3(0, 0, -20), Vec3::Zero()});
    for (int t = cycle_ms; t <= 50; t += cycle_ms) load.update(ms(t), bent(), tau);
    CHECK(load.load_n() == Approx(20.0 * (1.0 - std::exp(-1.0))).margin(1e-3));
  }
}

TEST_CASE("a state that came twice, late or broken is not felt", "[load]") {
  LoadEstimator load(built_in(), LoadConfig{});
  const JointVector tau = torques_of(bent(), {Vec3(0, 0, -20), Vec3::Zero()});
  load.update(ms(10), bent(), tau);
  JointVector broken = 10.0 * tau;
  load.update(ms(10), bent(), broken);
  load.update(ms(5), bent(), broken);
  broken[3] = std::numeric_limits<double>::quiet_NaN();
  load.update(ms(11), bent(), broken);
  load.update(ms(12), broken, tau);
  CHECK(load.load_n() == Approx(20.0).margin(1e-4));
}

TEST_CASE("feeling the load allocates nothing", "[load]") {
  LoadEstimator load(built_in(), LoadConfig{});
  const JointVector tau = torques_of(bent(), {Vec3(0, 0, -20), Vec3::Zero()});
  load.update(ms(0), bent(), tau);
  const auto before = allocations();
  for (int t = 1; t < 100; ++t) load.update(ms(t), bent(), tau);
  CHECK(allocations() == before);
}
