#include "hal/robot_model/robot_model.hpp"

#include <cmath>

#include "hal/robot_model/robot_joints.hpp"

namespace colift::hal {
namespace {

/// Turn of the outer link for each turn of the inner one: 125 / 375 teeth (maker's gear table).
constexpr double kCoupling = 1.0 / 3.0;

/// Right-multiplies by a turn about a unit axis.
void turn(Pose& pose, const Vec3& axis, double q_rad) {
  pose.linear() = (pose.linear() * Eigen::AngleAxisd(q_rad, axis)).eval();
}

template <class Value>
JointVector each_joint(const RobotModel& model, Value value) {
  JointVector out;
  for (int i = 0; i < kArmJoints; ++i) {
    out[i] = model.links[static_cast<std::size_t>(model.arm[static_cast<std::size_t>(i)])].*value;
  }
  return out;
}

}  // namespace

HandPosture posture_of(const HandState& state) {
  return {state.finger_rad, state.outer_rad, state.spread_rad};
}

HandPosture coupled_posture(double inner_rad, double spread_rad) {
  HandPosture hand;
  hand.inner_rad.fill(inner_rad);
  hand.outer_rad.fill(kCoupling * inner_rad);
  hand.spread_rad = spread_rad;
  return hand;
}

JointVector RobotModel::lower_rad() const {
  return each_joint(*this, &RobotLink::lower_rad);
}
JointVector RobotModel::upper_rad() const {
  return each_joint(*this, &RobotLink::upper_rad);
}
JointVector RobotModel::velocity_rad_s() const {
  return each_joint(*this, &RobotLink::velocity_rad_s);
}
JointVector RobotModel::effort_nm() const {
  return each_joint(*this, &RobotLink::effort_nm);
}

void link_poses(const RobotModel& model, const JointVector& q_rad, const HandPosture& hand,
                std::vector<Pose>& X_WL) {
  std::array<double, kMovingJoints> position{};
  for (int i = 0; i < kArmJoints; ++i) position[static_cast<std::size_t>(i)] = q_rad[i];
  for (std::size_t f = 0; f < kFingers; ++f) {
    position[kFirstInner + f] = hand.inner_rad[f];
    position[kFirstOuter + f] = hand.outer_rad[f];
  }
  position[kFirstSpread] = position[kFirstSpread + 1] = hand.spread_rad;

  X_WL.resize(model.links.size());
  for (std::size_t i = 0; i < model.links.size(); ++i) {
    const RobotLink& link = model.links[i];
    X_WL[i] = link.parent < 0 ? link.X_PL0 : X_WL[static_cast<std::size_t>(link.parent)] * link.X_PL0;
    const int by = model.turned_by_[i];
    if (by >= 0) turn(X_WL[i], link.axis, position[static_cast<std::size_t>(by)]);
  }
}

Pose hand_pose(const RobotModel& model, const JointVector& q_rad) {
  Pose X_WL = Pose::Identity();
  for (const int i : model.palm_chain_) {
    const RobotLink& link = model.links[static_cast<std::size_t>(i)];
    X_WL = X_WL * link.X_PL0;
    const int by = model.turned_by_[static_cast<std::size_t>(i)];
    if (by >= 0) turn(X_WL, link.axis, q_rad[by]);
  }
  return X_WL;
}

ArmJacobian jacobian(const RobotModel& model, const JointVector& q_rad, const Vec3& p_H) {
  std::array<Vec3, kArmJoints> origin_W, axis_W;
  Pose X_WL = Pose::Identity();
  for (const int i : model.palm_chain_) {
    const RobotLink& link = model.links[static_cast<std::size_t>(i)];
    X_WL = X_WL * link.X_PL0;
    const int by = model.turned_by_[static_cast<std::size_t>(i)];
    if (by < 0) continue;
    origin_W[static_cast<std::size_t>(by)] = X_WL.translation();
    axis_W[static_cast<std::size_t>(by)] = X_WL.linear() * link.axis;
    turn(X_WL, link.axis, q_rad[by]);
  }
  const Vec3 p_W = X_WL * p_H;
  ArmJacobian J;
  for (int i = 0; i < kArmJoints; ++i) {
    const Vec3& axis = axis_W[static_cast<std::size_t>(i)];
    J.col(i) << axis.cross(p_W - origin_W[static_cast<std::size_t>(i)]), axis;
  }
  return J;
}

}  // namespace colift::hal
