#include "control/lift/cartesian_impedance.hpp"

#include <catch2/catch.hpp>
#include <random>

#include "hal/types/symmetric.hpp"
#include "hal/types/units.hpp"
#include "tests/unit/control/allocations.hpp"

using namespace colift;
using control::CartesianConfig;
using control::CartesianImpedance;
using hal::JointVector;
using hal::Vec3;

namespace {

constexpr double kJoint_nm_rad = 1500.0, kPeriod_s = 0.005;

JointVector posture() {
  JointVector q;
  q << 0.1, 0.35, -0.2, 1.75, 0.3, -0.9, 0.4;
  return q;
}

hal::ImpedanceCommand joints_at(const JointVector& q_rad, double stiffness = kJoint_nm_rad) {
  hal::ImpedanceCommand c;
  c.q_rad = q_rad;
  c.stiffness_nm_rad.setConstant(stiffness);
  return c;
}

CartesianImpedance engaged(const CartesianConfig& config = {}) {
  CartesianImpedance palm(hal::built_in_robot(), config, kJoint_nm_rad, {}, 1e9);
  palm.engage(true);
  for (int i = 0; i < 200; ++i) (void)palm.apply(posture(), joints_at(posture()), kPeriod_s);
  REQUIRE(palm.weight() == 1.0);
  return palm;
}

/// What the arm's joints give altogether where it stands.
JointVector total_nm(const hal::ImpedanceCommand& c, const JointVector& q_rad) {
  return c.stiffness_nm_rad.cwiseProduct(c.q_rad - q_rad) + c.tau_superposed_nm;
}

/// Wrench of the arm on the world about the palm that these torques are in equilibrium with.
hal::Wrench wrench_of(const JointVector& tau_nm) {
  const hal::ArmJacobian J = hal::jacobian(hal::built_in_robot(), posture(), Vec3::Zero());
  const Eigen::Matrix<double, 6, 1> w = hal::solve_symmetric<double, 6>(J * J.transpose(), J * tau_nm);
  return {w.head<3>(), w.tail<3>()};
}

/// The posture whose palm stands `p` beside that of posture(), by small steps.
JointVector beside(const Vec3& p) {
  const hal::ArmJacobian J = hal::jacobian(hal::built_in_robot(), posture(), Vec3::Zero());
  Eigen::Matrix<double, 6, 1> dx = Eigen::Matrix<double, 6, 1>::Zero();
  dx.head<3>() = p;
  return posture() + J.transpose() * hal::solve_symmetric<double, 6>(J * J.transpose(), dx);
}

}  // namespace

TEST_CASE("the palm is stiff along gravity and soft sideways") {
  CartesianImpedance palm = engaged();
  const CartesianConfig config;
  const JointVector q = posture();
  constexpr double kAside_m = 0.001;
  for (int axis = 0; axis < 3; ++axis) {
    const hal::Wrench w =
        wrench_of(total_nm(palm.apply(q, joints_at(beside(kAside_m * Vec3::Unit(axis))), kPeriod_s), q));
    const double expected = kAside_m * (axis == 2 ? config.up_n_m : config.side_n_m);
    INFO("axis " << axis);
    CHECK(w.force[axis] == Approx(expected).epsilon(0.01));
    CHECK((w.force - w.force[axis] * Vec3::Unit(axis)).norm() < 0.02 * expected);
  }
}

TEST_CASE("a load that is fed forward goes through unchanged, and a set point at the palm gives no force") {
  CartesianImpedance palm = engaged();
  hal::ImpedanceCommand c = joints_at(posture());
  c.tau_superposed_nm << 0.0, 12.0, 0.0, -6.0, 0.0, 1.0, 0.0;
  CHECK((total_nm(palm.apply(posture(), c, kPeriod_s), posture()) - c.tau_superposed_nm).norm() < 1e-9);
  CHECK(palm.spring_nm().norm() < 1e-9);
}

TEST_CASE("springs of the palm and of the null space are those of one energy") {
  // symmetric, positive definite, whatever the posture: what is put in comes out again
  const hal::RobotModel& model = hal::built_in_robot();
  std::mt19937 random(7);
  std::uniform_real_distribution<double> part(0.1, 0.9);
  for (int n = 0; n < 50; ++n) {
    JointVector q;
    for (int i = 0; i < hal::kArmJoints; ++i)
      q[i] = model.lower_rad()[i] + part(random) * (model.upper_rad() - model.lower_rad())[i];
    CartesianImpedance palm(model, {}, kJoint_nm_rad, {}, 1e9);
    palm.engage(true);
    for (int i = 0; i < 200; ++i) (void)palm.apply(q, joints_at(q), kPeriod_s);
    Eigen::Matrix<double, 7, 7> K;
    constexpr double kStep = 1e-5;
    for (int i = 0; i < hal::kArmJoints; ++i) {
      const JointVector off = kStep * JointVector::Unit(i);
      K.col(i) = total_nm(palm.apply(q, joints_at(q + off), kPeriod_s), q) / kStep;
    }
    CHECK((K - K.transpose()).norm() < 1e-3 * K.norm());
    CHECK(hal::small_symmetric_eigen(0.5 * (K + K.transpose())).values.minCoeff() > -1e-3 * K.norm());
  }
}

TEST_CASE("an arm that yields softens its palm alike") {
  CartesianImpedance palm = engaged();
  const JointVector aside = beside(Vec3(0.0, 0.0, 0.002));
  const double stiff_n =
      wrench_of(total_nm(palm.apply(posture(), joints_at(aside), kPeriod_s), posture())).force.z();
  const double soft_n =
      wrench_of(total_nm(palm.apply(posture(), joints_at(aside, 0.1 * kJoint_nm_rad), kPeriod_s), posture()))
          .force.z();
  CHECK(soft_n == Approx(0.1 * stiff_n).epsilon(0.01));
}

TEST_CASE("one impedance turns into the other without a jump, and a restart superposes nothing") {
  constexpr double kSlope_nm_s = 150.0;
  hal::ArmAbilities weak;
  weak.max_superposed_nm.setConstant(50.0);
  CartesianImpedance palm(hal::built_in_robot(), {}, kJoint_nm_rad, weak, kSlope_nm_s);
  const JointVector q = posture(), aside = beside(Vec3(0.01, 0.0, 0.005));
  hal::ImpedanceCommand before = palm.apply(q, joints_at(aside), kPeriod_s);
  CHECK(before.stiffness_nm_rad == joints_at(aside).stiffness_nm_rad);
  for (const bool on : {true, false}) {
    palm.engage(on);
    for (int i = 0; i < 300; ++i) {
      const hal::ImpedanceCommand now = palm.apply(q, joints_at(aside), kPeriod_s);
      const JointVector change = now.tau_superposed_nm - before.tau_superposed_nm;
      CHECK(change.cwiseAbs().maxCoeff() <= kSlope_nm_s * kPeriod_s + 1e-9);
      CHECK(now.tau_superposed_nm.cwiseAbs().maxCoeff() <= 50.0);
      CHECK(now.stiffness_nm_rad.minCoeff() >= 0.0);
      CHECK(now.stiffness_nm_rad.maxCoeff() <= 2000.0);
      before = now;
    }
    CHECK(palm.weight() == (on ? 1.0 : 0.0));
    if (on) CHECK(before.tau_superposed_nm.norm() > 0.1);
  }
  CHECK(before.tau_superposed_nm.isZero());
  palm.engage(true);
  for (int i = 0; i < 100; ++i) (void)palm.apply(q, joints_at(aside), kPeriod_s);
  palm.reset();
  CHECK(palm.apply(q, joints_at(q), 0.0).tau_superposed_nm.isZero());
}

TEST_CASE("a singular posture and a position that is no number are survived") {
  CartesianImpedance palm = engaged();
  const JointVector straight = JointVector::Zero();
  const auto c = palm.apply(straight, joints_at(straight + JointVector::Constant(0.01)), kPeriod_s);
  CHECK(c.tau_superposed_nm.allFinite());
  CHECK(c.stiffness_nm_rad.allFinite());
  JointVector lost = posture();
  lost[2] = NAN;
  const auto d = palm.apply(lost, joints_at(posture()), kPeriod_s);
  CHECK(d.tau_superposed_nm.allFinite());
  CHECK(d.stiffness_nm_rad.allFinite());
}

TEST_CASE("a cycle of the palm's impedance allocates nothing") {
  CartesianImpedance palm = engaged();
  const JointVector aside = beside(Vec3(0.01, 0.0, 0.005));
  const auto joints = joints_at(aside);
  const std::uint64_t before = allocations();
  for (int i = 0; i < 10; ++i) (void)palm.apply(posture(), joints, kPeriod_s);
  CHECK(allocations() == before);
}
