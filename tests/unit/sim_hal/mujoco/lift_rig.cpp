#include "lift_rig.hpp"

#include <algorithm>
#include <catch2/catch.hpp>

#include "hal/types/symmetric.hpp"
#include "sim_hal/synthetic/hash_random.hpp"

namespace colift::sim_hal {
namespace {

using hal::JointVector;

constexpr auto kCycle = std::chrono::milliseconds(5);

// damped least squares
JointVector follow(const Pose& X_WH, JointVector q, int steps) {
  const hal::RobotModel& robot = hal::built_in_robot();
  for (int i = 0; i < steps; ++i) {
    const Pose X = hal::hand_pose(robot, q);
    const Eigen::AngleAxisd turn(X_WH.linear() * X.linear().transpose());
    Eigen::Matrix<double, 6, 1> error;
    error << X_WH.translation() - X.translation(), turn.angle() * turn.axis();
    if (error.norm() < 1e-9) break;
    error *= std::min(1.0, 0.2 / error.norm());
    const hal::ArmJacobian J = hal::jacobian(robot, q, Vec3::Zero());
    Eigen::Matrix<double, 6, 6> A = J * J.transpose();
    A.diagonal().array() += 1e-5;
    q += J.transpose() * hal::solve_symmetric<double, 6>(A, error);
  }
  return q;
}

double min_jerk(double x) {
  return x * x * x * (10.0 + x * (-15.0 + 6.0 * x));
}

}  // namespace

Pose hand_at(const Vec3& p_W, const Vec3& approach, const Vec3& closing) {
  Pose X = Pose::Identity();
  X.linear() << closing.cross(approach), closing, approach;
  X.translation() = p_W;
  return X;
}

JointVector reach(const Pose& X_WH) {
  const hal::RobotModel& robot = hal::built_in_robot();
  const JointVector lower = robot.lower_rad(), upper = robot.upper_rad();
  Draws draws(5, 0);
  JointVector best = JointVector::Zero();
  double widest = 0.0;
  for (int start = 0; start < 80 && widest < 0.35; ++start) {
    JointVector q = SimConfig::home_rad();
    for (int i = 0; i < hal::kArmJoints; ++i) q[i] += draws.between(-1.6, 1.6);
    q = follow(X_WH, q, 100);
    const Pose off = hal::hand_pose(robot, q).inverse() * X_WH;
    if (off.translation().norm() > 1e-6 || !off.linear().isIdentity(1e-6)) continue;
    // away from limits and from the singular straight elbow and wrist
    const double room =
        std::min({(q - lower).minCoeff(), (upper - q).minCoeff(), std::abs(q[3]), std::abs(q[5])});
    if (room > widest) widest = room, best = q;
  }
  REQUIRE(widest > 0.05);
  return best;
}

LiftRig::LiftRig(const Scenario& scenario, const Pose& X_WH_start, std::uint64_t seed) : X_WH_(X_WH_start) {
  SimConfig config;
  config.start_rad = reach(X_WH_start);
  command_.q_rad = config.start_rad;
  command_.stiffness_nm_rad.setConstant(1500.0);
  auto world = SimWorld::make(scenario, hal::built_in_robot(), seed, config);
  INFO((world ? std::string() : world.error().text()));
  REQUIRE(world);
  world_ = std::move(*world);
}

void LiftRig::cycle() {
  command_.q_rad = follow(X_WH_, command_.q_rad, 20);
  // the load hangs about 8 cm before the palm
  const hal::ArmJacobian J = hal::jacobian(hal::built_in_robot(), command_.q_rad, {0.0, 0.0, 0.08});
  command_.tau_superposed_nm = J.row(2).transpose() * load_n_;
  world_->command_arm(command_);
  if (!each_ms_) return world_->advance(kCycle);
  for (int ms = 0; ms < 5; ++ms) {
    world_->advance(std::chrono::milliseconds(1));
    each_ms_();
  }
}

void LiftRig::move_watched(const Vec3& p_W, double time_s, std::function<void()> each_ms) {
  each_ms_ = std::move(each_ms);
  move(p_W, time_s);
  each_ms_ = nullptr;
}

void LiftRig::move(const Vec3& p_W, double time_s, double load_n) {
  const Vec3 from = X_WH_.translation();
  const double load_from = load_n_;
  const int cycles = static_cast<int>(time_s / 0.005);
  for (int i = 1; i <= cycles; ++i) {
    const double x = static_cast<double>(i) / cycles;
    X_WH_.translation() = from + min_jerk(x) * (p_W - from);
    load_n_ = load_from + std::min(1.0, 5.0 * x) * (load_n - load_from);
    cycle();
  }
}

void LiftRig::wait(double time_s) {
  for (int i = static_cast<int>(time_s / 0.005); i > 0; --i) cycle();
}

bool LiftRig::close(double torque_nm) {
  world_->close_hand(torque_nm);
  for (int i = 0; i < 800; ++i) {
    cycle();
    if (!world_->hand_state().moving) return true;
  }
  return false;
}

SimTruth LiftRig::mean(double time_s) {
  SimTruth sum = world_->truth();
  sum.robot_force_W = sum.robot_torque_W = sum.partner_force_W = sum.floor_force_W = Vec3::Zero();
  const int cycles = static_cast<int>(time_s / 0.005);
  for (int i = 0; i < cycles; ++i) {
    cycle();
    const SimTruth now = world_->truth();
    sum.robot_force_W += now.robot_force_W / cycles;
    sum.robot_torque_W += now.robot_torque_W / cycles;
    sum.partner_force_W += now.partner_force_W / cycles;
    sum.floor_force_W += now.floor_force_W / cycles;
  }
  return sum;
}

Scenario table_scenario() {
  Scenario s;
  s.object.kind = "table";
  s.object.size = {0.8, 0.6, 0.45};
  s.object.mass = 4.0;
  s.object.friction = 0.7;
  s.object.xyz = {1.2, 0.0, 0.0};
  s.partner.kind = "compliant";
  s.partner.grasp = {0.4, 0.0, 0.4375};
  s.partner.arrives_s = 0.5;
  return s;
}

Pose before_edge() {
  return hand_at({0.60, 0.0, 0.4375}, Vec3::UnitX(), Vec3::UnitZ());
}

Vec3 around_edge() {
  return {0.755, 0.0, 0.4375};
}

}  // namespace colift::sim_hal
