#include "sim_hal/emulator/mujoco/krc_world_plant.hpp"

#include <fmt/format.h>

#include "sim_hal/emulator/krc/plant/krc_control_law.hpp"

namespace colift::sim_hal {
namespace {

constexpr hal::Duration kTick = std::chrono::milliseconds(1);
constexpr double kTick_s = 0.001;
constexpr double kStiffest_nm_rad = 2000.0;

}  // namespace

KrcWorldPlant::KrcWorldPlant(SimWorld& world, const hal::ArmDynamics& dynamics)
    : world_(world), dynamics_(dynamics), q_before_rad_(world.arm_state().q_rad) {
  set_point_.q_rad = brake_rad_ = q_before_rad_;
  brake_nm_.setZero();
  set_brakes(true);
}

hal::Result<> KrcWorldPlant::set_cycle(hal::Duration cycle) {
  if (cycle == world_.config().arm_period) return {};
  return hal::failure(hal::ErrorCode::BadConfig, "krc.plant",
                      fmt::format("the simulated world interpolates over {:g} ms, and the cycle is {:g} ms",
                                  1e3 * hal::seconds(world_.config().arm_period), 1e3 * hal::seconds(cycle)));
}

void KrcWorldPlant::command(const KrcSetPoint& set_point) {
  set_point_ = set_point;
  fresh_ = true;
}

void KrcWorldPlant::set_brakes(bool closed) {
  if (closed && !brakes_) {
    const hal::ArmState arm = world_.arm_state();
    brake_rad_ = arm.q_rad;
    brake_nm_ = -arm.tau_external_nm;  // what hangs on the arm may not move it while the brakes close
  }
  if (closed != brakes_) fresh_ = true;
  brakes_ = closed;
}

hal::JointVector KrcWorldPlant::push_nm() const {
  if (push_.isZero()) return hal::JointVector::Zero();
  return dynamics_.jacobian(world_.arm_state().q_rad).transpose() * push_;
}

void KrcWorldPlant::tell_world() {
  hal::ImpedanceCommand c;
  if (brakes_) {
    c.q_rad = brake_rad_;
    c.stiffness_nm_rad.setConstant(kStiffest_nm_rad);
    c.damping_ratio.setOnes();
    c.tau_superposed_nm = brake_nm_;
  } else {
    c.q_rad = set_point_.q_rad;
    c.stiffness_nm_rad = set_point_.stiffness_nm_rad;
    c.damping_ratio = set_point_.damping_ratio;
    c.tau_superposed_nm = set_point_.tau_nm + push_nm();
    if (set_point_.control == FriControl::Position) {
      c.stiffness_nm_rad.setConstant(kStiffest_nm_rad);
      c.damping_ratio.setOnes();
    }
  }
  world_.command_arm(c);
}

void KrcWorldPlant::tick_cartesian() {
  const hal::JointVector q = world_.arm_state().q_rad;
  const hal::JointMatrix M = dynamics_.mass_matrix(q);
  const hal::ArmJacobian J = dynamics_.jacobian(q);
  const JointLaw law = cartesian_impedance(set_point_, q, dynamics_.flange(q), J, M);
  // spring and damper as they will be at the end of the tick, as far as the arm alone decides it: an explicit
  // damper on the light last joints would ring
  const hal::JointMatrix A = M + kTick_s * law.damping + kTick_s * kTick_s * law.stiffness;
  const hal::JointVector dq = A.llt().solve(M * dq_rad_s_ + kTick_s * law.feed_nm);
  hal::ImpedanceCommand c;
  c.q_rad = q;
  c.stiffness_nm_rad.setZero();
  c.damping_ratio.setZero();
  c.tau_superposed_nm = law.feed_nm - law.damping * dq - kTick_s * law.stiffness * dq + J.transpose() * push_;
  world_.command_arm(c);
}

void KrcWorldPlant::advance(hal::Duration by) {
  const bool cartesian = !brakes_ && set_point_.control == FriControl::CartesianImpedance;
  if (!cartesian && fresh_) tell_world();
  fresh_ = false;
  for (auto ticks = by / kTick; ticks > 0; --ticks) {
    if (cartesian) tick_cartesian();
    world_.advance(kTick);
    const hal::JointVector q = world_.arm_state().q_rad;
    dq_rad_s_ = (q - q_before_rad_) / kTick_s;
    q_before_rad_ = q;
  }
}

KrcPlantState KrcWorldPlant::state() const {
  const hal::ArmState arm = world_.arm_state();
  const hal::JointVector push = push_nm();
  KrcPlantState s;
  s.q_rad = arm.q_rad;
  s.dq_rad_s = dq_rad_s_;
  // the push came in as motor torque, but it is none
  s.tau_nm = arm.tau_nm - push;
  s.tau_external_nm = arm.tau_external_nm + push;
  return s;
}

}  // namespace colift::sim_hal
