// What a controller computes in each cycle: pose of the flange, Jacobian, joint velocity for a twist of it
// (damped least squares), gravity torque. Ours against KDL's solvers with equal results.

#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <array>
#include <cstdlib>
#include <kdl/chaindynparam.hpp>
#include <kdl/chainfksolverpos_recursive.hpp>
#include <kdl/chainiksolvervel_wdls.hpp>
#include <kdl/chainjnttojacsolver.hpp>
#include <random>

#include "hal/robot_model/dynamics.hpp"
#include "tests/unit/planner/kdl/kdl_chain.hpp"

namespace {

using namespace colift;
using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

constexpr double kDamping = 0.05;
constexpr std::size_t kPostures = 256;

/// The arm of our URDF as KDL sees it: bodies link by link, joints about their own axes.
KDL::Chain chain_of(const hal::RobotModel& robot) {
  KDL::Chain chain;
  for (const int link : robot.arm) {
    const hal::RobotLink& l = robot.links[static_cast<std::size_t>(link)];
    chain.addSegment(KDL::Segment(KDL::Joint(KDL::Joint::None), test::to_kdl(l.X_PL0)));
    const auto& I = l.inertia;
    chain.addSegment(KDL::Segment(
        KDL::Joint(KDL::Vector::Zero(), KDL::Vector(l.axis.x(), l.axis.y(), l.axis.z()), KDL::Joint::RotAxis),
        KDL::Frame::Identity(),
        KDL::RigidBodyInertia(l.mass_kg, KDL::Vector(l.com_m.x(), l.com_m.y(), l.com_m.z()),
                              KDL::RotationalInertia(I(0, 0), I(1, 1), I(2, 2), I(0, 1), I(0, 2), I(1, 2)))));
  }
  return chain;
}

struct Tick {
  hal::Vec3 position = hal::Vec3::Zero();
  hal::JointVector dq_rad_s = hal::JointVector::Zero(), gravity_nm = hal::JointVector::Zero();
};

struct Ours {
  hal::ArmDynamics arm{hal::built_in_robot(), hal::ArmDynamics::Load::Bare};
  hal::Vec3 p_F;

  /// KDL's chain ends in the last joint's frame; p_F is that point seen from our flange.
  explicit Ours(const hal::Vec3& p) : p_F(p) {}

  Tick tick(const hal::JointVector& q, const Vector6& twist) const {
    Tick t;
    const hal::ArmDynamics::Tick now = arm.tick(q, p_F);
    t.position = now.X_WF * p_F;
    const hal::ArmJacobian& J = now.jacobian;
    Matrix6 JJ = J * J.transpose();
    JJ.diagonal().array() += kDamping * kDamping;
    t.dq_rad_s = J.transpose() * JJ.ldlt().solve(twist);
    t.gravity_nm = now.gravity_nm;
    return t;
  }
};

struct Kdl {
  KDL::Chain chain = chain_of(hal::built_in_robot());
  KDL::ChainFkSolverPos_recursive fk{chain};
  KDL::ChainJntToJacSolver jacobian{chain};
  KDL::ChainIkSolverVel_wdls ik{chain};
  KDL::ChainDynParam dynamics{chain, KDL::Vector(0.0, 0.0, -hal::kGravity_m_s2)};
  KDL::Jacobian J{7};
  KDL::JntArray dq{7}, g{7};

  Kdl() {
    // as ours: damped everywhere, not only near a singular posture
    ik.setLambda(kDamping);
    ik.setEps(1e9);
  }

  Tick tick(const hal::JointVector& q_rad, const Vector6& v) {
    const KDL::JntArray q = test::to_kdl(q_rad);
    KDL::Frame pose;
    const KDL::Twist twist(KDL::Vector(v[0], v[1], v[2]), KDL::Vector(v[3], v[4], v[5]));
    if (fk.JntToCart(q, pose) < 0 || jacobian.JntToJac(q, J) < 0 || ik.CartToJnt(q, twist, dq) < 0 ||
        dynamics.JntToGravity(q, g) < 0)
      std::abort();
    Tick t;
    t.position = {pose.p.x(), pose.p.y(), pose.p.z()};
    t.dq_rad_s = dq.data;
    t.gravity_nm = g.data;
    return t;
  }
};

struct Problem {
  hal::JointVector q_rad;
  Vector6 twist;
};

const std::array<Problem, kPostures>& problems() {
  static const std::array<Problem, kPostures> all = [] {
    std::array<Problem, kPostures> p;
    std::mt19937 random(7);
    std::uniform_real_distribution<double> angle(-1.5, 1.5), speed(-0.2, 0.2);
    for (Problem& x : p) {
      for (int i = 0; i < hal::kArmJoints; ++i) x.q_rad[i] = angle(random);
      for (int i = 0; i < 6; ++i) x.twist[i] = speed(random);
    }
    return p;
  }();
  return all;
}

hal::Vec3 end_of_chain() {
  // both at joint zero: where KDL's last frame lies in our flange's
  Kdl kdl;
  const hal::JointVector zero = hal::JointVector::Zero();
  const hal::ArmDynamics arm(hal::built_in_robot(), hal::ArmDynamics::Load::Bare);
  return arm.flange(zero).inverse() * kdl.tick(zero, Vector6::Zero()).position;
}

void ours(benchmark::State& state) {
  const Ours arm(end_of_chain());
  std::size_t i = 0;
  for (auto _ : state) {
    const Problem& p = problems()[i++ % kPostures];
    benchmark::DoNotOptimize(arm.tick(p.q_rad, p.twist));
  }
}
BENCHMARK(ours);

void kdl(benchmark::State& state) {
  Kdl arm;
  std::size_t i = 0;
  for (auto _ : state) {
    const Problem& p = problems()[i++ % kPostures];
    benchmark::DoNotOptimize(arm.tick(p.q_rad, p.twist));
  }
}
BENCHMARK(kdl);

/// Greatest difference over all problems.
bool agree() {
  const Ours mine(end_of_chain());
  Kdl theirs;
  double position = 0.0, gravity = 0.0, velocity = 0.0;
  for (const Problem& p : problems()) {
    const Tick a = mine.tick(p.q_rad, p.twist), b = theirs.tick(p.q_rad, p.twist);
    position = std::max(position, (a.position - b.position).norm());
    gravity = std::max(gravity, (a.gravity_nm - b.gravity_nm).cwiseAbs().maxCoeff());
    velocity = std::max(velocity, (a.dq_rad_s - b.dq_rad_s).cwiseAbs().maxCoeff());
  }
  fmt::print(
      "greatest difference over {} postures: position {:.1e} m, gravity {:.1e} N m, joint velocity {:.1e} "
      "rad/s\n",
      kPostures, position, gravity, velocity);
  return position < 1e-9 && gravity < 1e-9 && velocity < 1e-6;
}

}  // namespace

int main(int argc, char** argv) {
  if (!agree()) {
    fmt::print("ours and KDL differ: nothing is timed\n");
    return 1;
  }
  benchmark::Initialize(&argc, argv);
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
