#include "hal/robot_model/dynamics.hpp"

#include <cmath>

namespace colift::hal {
namespace {

constexpr std::size_t kJoints = kArmJoints;

/// Inertia about a point for the inertia about the centre of mass that lies at `com` from it.
Eigen::Matrix3d shifted(const Eigen::Matrix3d& inertia, double mass_kg, const Vec3& com) {
  return inertia + mass_kg * (com.squaredNorm() * Eigen::Matrix3d::Identity() - com * com.transpose());
}

}  // namespace

ArmDynamics::ArmDynamics(const RobotModel& model, Load load, const HandPosture& hand) {
  std::vector<Pose> X_WL;
  link_poses(model, JointVector::Zero(), hand, X_WL);
  Pose X_WP = Pose::Identity();
  for (std::size_t i = 0; i < kJoints; ++i) {
    const auto link = static_cast<std::size_t>(model.arm[i]);
    bodies_[i].X_PB0 = X_WP.inverse() * X_WL[link];
    bodies_[i].axis = model.links[link].axis;
    X_WP = X_WL[link];
  }
  X_A7F_ = X_WP.inverse() * X_WL[static_cast<std::size_t>(model.flange)];

  for (std::size_t l = 0; l < model.links.size(); ++l) {
    if (load == Load::Bare && model.in_hand(static_cast<int>(l))) continue;
    const auto turned_by_arm = [&](int i) {
      const int by = model.turned_by_[static_cast<std::size_t>(i)];
      return by >= 0 && by < kArmJoints;
    };
    int carrier = static_cast<int>(l);
    while (carrier >= 0 && !turned_by_arm(carrier))
      carrier = model.links[static_cast<std::size_t>(carrier)].parent;
    if (carrier < 0) continue;  // part of the base
    const RobotLink& link = model.links[l];
    const Pose X_BL = X_WL[static_cast<std::size_t>(carrier)].inverse() * X_WL[l];
    const Vec3 com = X_BL * link.com_m;
    const Eigen::Matrix3d inertia = X_BL.linear() * link.inertia * X_BL.linear().transpose();
    Body& body = bodies_[static_cast<std::size_t>(model.turned_by_[static_cast<std::size_t>(carrier)])];
    body.mass_kg += link.mass_kg;
    body.moment += link.mass_kg * com;
    body.inertia += shifted(inertia, link.mass_kg, com);
  }
  for (Body& body : bodies_) {
    const Vec3& a = body.axis;
    const Eigen::Matrix3d R0 = body.X_PB0.linear();
    Eigen::Matrix3d cross;
    cross << 0.0, -a.z(), a.y(), a.z(), 0.0, -a.x(), -a.y(), a.x(), 0.0;
    body.fixed = R0 * a * a.transpose();
    body.sine = R0 * cross;
    body.cosine = R0 - body.fixed;
  }
}

ArmDynamics::Places ArmDynamics::places(const JointVector& q_rad) const {
  Places places;
  for (std::size_t i = 0; i < kJoints; ++i) {
    const Body& body = bodies_[i];
    const double q = q_rad[static_cast<int>(i)];
    places[i].R = body.fixed + std::sin(q) * body.sine + std::cos(q) * body.cosine;
    places[i].p = body.X_PB0.translation();
  }
  return places;
}

JointVector ArmDynamics::gravity_nm(const JointVector& q_rad) const {
  return torque_nm(q_rad, JointVector::Zero(), JointVector::Zero());
}

JointVector ArmDynamics::torque_nm(const JointVector& q_rad, const JointVector& dq_rad_s,
                                   const JointVector& ddq_rad_s2) const {
  const Places at = places(q_rad);
  std::array<Vec3, kJoints> force, torque;
  // a base that accelerates upwards feels like gravity
  Vec3 turning = Vec3::Zero(), turning_up = Vec3::Zero(), moving_up(0.0, 0.0, kGravity_m_s2);
  for (std::size_t i = 0; i < kJoints; ++i) {
    const Body& body = bodies_[i];
    const Place& place = at[i];
    const double rate = dq_rad_s[static_cast<int>(i)];
    const Vec3 from_before =
        moving_up + turning_up.cross(place.p) + turning.cross(Vec3(turning.cross(place.p)));
    const Vec3 w = place.R.transpose() * turning;
    turning = w + rate * body.axis;
    turning_up = place.R.transpose() * turning_up + ddq_rad_s2[static_cast<int>(i)] * body.axis +
                 w.cross(Vec3(rate * body.axis));
    moving_up = place.R.transpose() * from_before;
    force[i] = body.mass_kg * moving_up + turning_up.cross(body.moment) +
               turning.cross(Vec3(turning.cross(body.moment)));
    torque[i] = body.inertia * turning_up + turning.cross(Vec3(body.inertia * turning)) +
                body.moment.cross(moving_up);
  }
  JointVector tau;
  for (std::size_t i = kJoints; i-- > 0;) {
    tau[static_cast<int>(i)] = bodies_[i].axis.dot(torque[i]);
    if (i == 0) break;
    const Vec3 f = at[i].R * force[i];
    force[i - 1] += f;
    torque[i - 1] += at[i].R * torque[i] + at[i].p.cross(f);
  }
  return tau;
}

JointMatrix ArmDynamics::mass_matrix(const JointVector& q_rad) const {
  const Places at = places(q_rad);
  Bodies whole = bodies_;  // each body with all that it carries
  for (std::size_t i = kJoints - 1; i > 0; --i) {
    const Body& child = whole[i];
    Body& body = whole[i - 1];
    const Vec3& p = at[i].p;
    const Vec3 moment = at[i].R * child.moment;
    const Eigen::Matrix3d turned = at[i].R * child.inertia * at[i].R.transpose();
    // moved by p without the detour over the centre of mass: sum over m of |p + r|^2 - (p + r)(p + r)^T
    body.inertia += turned +
                    (2.0 * p.dot(moment) + child.mass_kg * p.squaredNorm()) * Eigen::Matrix3d::Identity() -
                    p * moment.transpose() - moment * p.transpose() - child.mass_kg * p * p.transpose();
    body.moment += moment + child.mass_kg * p;
    body.mass_kg += child.mass_kg;
  }
  JointMatrix M;
  for (std::size_t i = 0; i < kJoints; ++i) {
    const Body& body = whole[i];
    Vec3 force = body.axis.cross(body.moment);
    Vec3 torque = body.inertia * body.axis;
    const auto row = static_cast<int>(i);
    M(row, row) = body.axis.dot(torque);
    for (std::size_t j = i; j > 0; --j) {
      force = at[j].R * force;
      torque = at[j].R * torque + at[j].p.cross(force);
      const auto column = static_cast<int>(j) - 1;
      M(row, column) = M(column, row) = bodies_[j - 1].axis.dot(torque);
    }
  }
  return M;
}

ArmDynamics::Tick ArmDynamics::tick(const JointVector& q_rad, const Vec3& p_F) const {
  std::array<Vec3, kJoints> origin_W, axis_W, moment_W;  // moment: mass times centre of mass, from W's origin
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  Vec3 p = Vec3::Zero();
  const Places at = places(q_rad);
  for (std::size_t i = 0; i < kJoints; ++i) {
    p += R * at[i].p;
    R = (R * at[i].R).eval();
    origin_W[i] = p;
    axis_W[i].noalias() = R * bodies_[i].axis;
    moment_W[i].noalias() = R * bodies_[i].moment;
    moment_W[i] += bodies_[i].mass_kg * p;
  }
  Tick tick;
  tick.X_WF.linear().noalias() = R * X_A7F_.linear();
  tick.X_WF.translation() = p + R * X_A7F_.translation();
  const Vec3 p_W = tick.X_WF * p_F;
  double mass_kg = 0.0;
  Vec3 moment = Vec3::Zero();
  for (std::size_t i = kJoints; i-- > 0;) {
    const auto column = static_cast<int>(i);
    tick.jacobian.col(column) << axis_W[i].cross(p_W - origin_W[i]), axis_W[i];
    mass_kg += bodies_[i].mass_kg;
    moment += moment_W[i];
    // what lies beyond the joint, weighed at its arm: axis . (arm x up)
    const Vec3 arm = moment - mass_kg * origin_W[i];
    tick.gravity_nm[column] = kGravity_m_s2 * (axis_W[i].x() * arm.y() - axis_W[i].y() * arm.x());
  }
  return tick;
}

Pose ArmDynamics::flange(const JointVector& q_rad) const {
  Pose X = Pose::Identity();
  for (const Place& place : places(q_rad)) {
    X.translation() += X.linear() * place.p;
    X.linear() = (X.linear() * place.R).eval();
  }
  return X * X_A7F_;
}

ArmJacobian ArmDynamics::jacobian(const JointVector& q_rad, const Vec3& p_F) const {
  const Places at = places(q_rad);
  std::array<Vec3, kJoints> origin_W, axis_W;
  Pose X = Pose::Identity();
  for (std::size_t i = 0; i < kJoints; ++i) {
    X.translation() += X.linear() * at[i].p;
    X.linear() = (X.linear() * at[i].R).eval();
    origin_W[i] = X.translation();
    axis_W[i] = X.linear() * bodies_[i].axis;
  }
  const Vec3 p_W = X * (X_A7F_ * p_F);
  ArmJacobian J;
  for (std::size_t i = 0; i < kJoints; ++i)
    J.col(static_cast<int>(i)) << axis_W[i].cross(p_W - origin_W[i]), axis_W[i];
  return J;
}

}  // namespace colift::hal
