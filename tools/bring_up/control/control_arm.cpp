#include "tools/bring_up/control/control_arm.hpp"

namespace colift::tools {

ControlArm::ControlArm(std::unique_ptr<hal::FriArm> fri, const hal::RobotModel& model)
    : fri_(std::move(fri)),
      dynamics_(model, hal::ArmDynamics::Load::Bare),
      control_(fri_->config().control) {}

hal::Result<> ControlArm::activate() {
  if (auto set = fri_->set_control(control_); !set) return set;
  return fri_->activate();
}

hal::Result<hal::ArmState> ControlArm::wait_cycle() {
  auto state = fri_->wait_cycle();
  if (state) measured_rad_ = state->q_rad;
  return state;
}

hal::Result<> ControlArm::command(const hal::ImpedanceCommand& c) {
  if (fri_->control() == hal::FriControl::JointImpedance) return fri_->command(c);
  if (fri_->control() == hal::FriControl::Position) return fri_->command_position(c.q_rad);
  // measured joints and measured frame are of one datagram: what lies between them is the KRC's tool
  const hal::FriConfig& config = fri_->config();
  const hal::Pose X_WF = dynamics_.flange(measured_rad_);
  hal::CartesianCommand frame;
  frame.X =
      dynamics_.flange(c.q_rad) * X_WF.inverse() * hal::from_wire_frame(fri_->measurement().cart_measured);
  frame.stiffness.head<3>().setConstant(config.start_cart_stiffness_n_m);
  frame.stiffness.tail<3>().setConstant(config.start_cart_stiffness_nm_rad);
  frame.damping_ratio.setConstant(config.start_damping);
  if (config.null_space_posture) frame.posture_rad = c.q_rad;
  return fri_->command_cartesian(frame);
}

}  // namespace colift::tools
