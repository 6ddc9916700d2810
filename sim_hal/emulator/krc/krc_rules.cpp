#include "sim_hal/emulator/krc/krc_rules.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "hal/types/units.hpp"
#include "sim_hal/emulator/krc/plant/krc_control_law.hpp"

namespace colift::sim_hal {
namespace {

using hal::kArmJoints;
// room for rounding in a float
constexpr double kRounding = 2e-6;

bool has(const KrcCommand& c, std::uint32_t flag) {
  return (c.flags & flag) != 0;
}

template <std::size_t N>
bool finite(const std::array<float, N>& all) {
  return std::all_of(all.begin(), all.end(), [](float v) { return std::isfinite(v); });
}

std::uint32_t flags_of(FriControl control) {
  using namespace fri_flag;
  switch (control) {
    case FriControl::Position:
      return kJointPosition;
    case FriControl::CartesianImpedance:
      return kJointPosition | kCartPosition | kTcpWrench | kCartStiffness | kCartDamping;
    case FriControl::JointImpedance:
      return kJointPosition | kJointTorque | kJointStiffness | kJointDamping;
    case FriControl::Other:
      return 0;
  }
  return 0;
}

std::string_view words(FriControl control) {
  switch (control) {
    case FriControl::Position:
      return "position control";
    case FriControl::CartesianImpedance:
      return "Cartesian impedance";
    case FriControl::JointImpedance:
      return "joint impedance";
    case FriControl::Other:
      return "gravity compensation";
  }
  return "";
}

std::optional<KrcBreach> check_numbers(const KrcCommand& c) {
  const auto bad = [](const char* field) {
    return KrcBreach{KrcRule::NotFinite, fmt::format("{} holds a number that is none", field)};
  };
  if (has(c, fri_flag::kJointPosition) && !finite(c.q_rad)) return bad("jntPos");
  if (has(c, fri_flag::kJointTorque) && !finite(c.tau_nm)) return bad("addJntTrq");
  if (has(c, fri_flag::kJointStiffness) && !finite(c.stiffness_nm_rad)) return bad("jntStiffness");
  if (has(c, fri_flag::kJointDamping) && !finite(c.damping)) return bad("jntDamping");
  if (has(c, fri_flag::kCartPosition) && !finite(c.X_WT)) return bad("cartPos");
  if (has(c, fri_flag::kTcpWrench) && !finite(c.wrench)) return bad("addTcpFT");
  if (has(c, fri_flag::kCartStiffness) && !finite(c.cart_stiffness)) return bad("cartStiffness");
  if (has(c, fri_flag::kCartDamping) && !finite(c.cart_damping)) return bad("cartDamping");
  if (has(c, fri_flag::kCartPosition) && !frame_of(c.X_WT))
    return KrcBreach{KrcRule::NotFinite, "cartPos holds a rotation that is none"};
  return std::nullopt;
}

std::optional<KrcBreach> check_range(double value, double most, const std::string& what) {
  if (value >= 0.0 && value <= most * (1.0 + kRounding)) return std::nullopt;
  return KrcBreach{KrcRule::GainOutOfRange, fmt::format("{} of {:g} (limit 0 to {:g})", what, value, most)};
}

std::optional<KrcBreach> check_gains(const KrcCommand& c, const KrcLimits& limits) {
  static constexpr std::array<const char*, 6> kAxis{"X", "Y", "Z", "Rz", "Ry", "Rx"};
  for (std::size_t i = 0; i < kArmJoints; ++i) {
    const std::string joint = joint_name(static_cast<int>(i));
    if (has(c, fri_flag::kJointStiffness))
      if (auto b = check_range(c.stiffness_nm_rad[i], limits.stiffness_nm_rad,
                               fmt::format("joint {} was given a stiffness", joint)))
        return b;
    if (has(c, fri_flag::kJointDamping))
      if (auto b = check_range(c.damping[i], limits.damping,
                               fmt::format("joint {} was given a damping ratio", joint)))
        return b;
  }
  for (std::size_t i = 0; i < 6; ++i) {
    if (has(c, fri_flag::kCartStiffness))
      if (auto b = check_range(c.cart_stiffness[i],
                               i < 3 ? limits.cart_stiffness_n_m : limits.cart_stiffness_nm_rad,
                               fmt::format("direction {} was given a stiffness", kAxis[i])))
        return b;
    if (has(c, fri_flag::kCartDamping))
      if (auto b = check_range(c.cart_damping[i], limits.damping,
                               fmt::format("direction {} was given a damping ratio", kAxis[i])))
        return b;
  }
  return std::nullopt;
}

std::optional<KrcBreach> check_positions(const KrcCommand& c, const KrcLimits& limits) {
  if (!has(c, fri_flag::kJointPosition)) return std::nullopt;
  const hal::JointVector q = joints_of(c.q_rad);
  for (int i = 0; i < kArmJoints; ++i)
    if (std::abs(q[i]) > limits.position_rad[i] + kRounding)
      return KrcBreach{KrcRule::PositionLimit, fmt::format("joint {} asked for {:.4f} rad (limit {:.4f} rad)",
                                                           joint_name(i), q[i], limits.position_rad[i])};
  return std::nullopt;
}

std::optional<KrcBreach> check_steps(const KrcCommand& c, const KrcJudgedAt& at, const KrcLimits& limits) {
  const double time_s = at.since_s * at.safety_limits;
  // in Cartesian impedance jntPos is a posture and moves nothing by itself
  if (has(c, fri_flag::kJointPosition) && at.control != FriControl::CartesianImpedance) {
    const hal::JointVector step = joints_of(c.q_rad) - at.q_rad;
    for (int i = 0; i < kArmJoints; ++i)
      if (const double most = limits.velocity_rad_s[i] * time_s; std::abs(step[i]) > most + kRounding)
        return KrcBreach{KrcRule::StepTooLarge,
                         fmt::format("joint {} asked for a step of {:.4f} rad (limit {:.4f} rad)",
                                     joint_name(i), std::abs(step[i]), most)};
  }
  if (has(c, fri_flag::kCartPosition)) {
    const Vector6 step = frame_difference(at.X_WT, *frame_of(c.X_WT));
    const double move_m = step.head<3>().norm(), turn_rad = step.tail<3>().norm();
    if (move_m > limits.speed_m_s * time_s + kRounding || turn_rad > limits.turning_rad_s * time_s + 1e-4)
      return KrcBreach{
          KrcRule::FrameStepTooLarge,
          fmt::format("the tool asked for a step of {:.4f} m and {:.4f} rad (limits {:.4f} m, {:.4f} rad)",
                      move_m, turn_rad, limits.speed_m_s * time_s, limits.turning_rad_s * time_s)};
  }
  return std::nullopt;
}

std::optional<KrcBreach> check_torques(const KrcCommand& c, const KrcJudgedAt& at, const KrcLimits& limits) {
  if (at.control == FriControl::JointImpedance) {
    hal::JointVector tau = hal::JointVector::Zero();
    const hal::JointVector K =
        has(c, fri_flag::kJointStiffness) ? joints_of(c.stiffness_nm_rad) : at.stiffness_nm_rad;
    if (has(c, fri_flag::kJointPosition)) tau += K.cwiseProduct(joints_of(c.q_rad) - at.q_measured_rad);
    if (has(c, fri_flag::kJointTorque)) tau += joints_of(c.tau_nm);
    for (int i = 0; i < kArmJoints; ++i)
      if (std::abs(tau[i]) > limits.torque_nm[i])
        return KrcBreach{KrcRule::TorqueLimit,
                         fmt::format("joint {} asked for {:.1f} N m of spring and torque (limit {:.1f} N m)",
                                     joint_name(i), tau[i], limits.torque_nm[i])};
  }
  if (at.control == FriControl::CartesianImpedance) {
    Vector6 wrench = Vector6::Zero();
    const Vector6 K = has(c, fri_flag::kCartStiffness) ? usual_order(c.cart_stiffness) : at.cart_stiffness;
    if (has(c, fri_flag::kCartPosition))
      wrench += K.cwiseProduct(frame_difference(at.X_WT_measured, *frame_of(c.X_WT)));
    if (has(c, fri_flag::kTcpWrench)) wrench += usual_order(c.wrench);
    const double force_n = wrench.head<3>().norm(), moment_nm = wrench.tail<3>().norm();
    if (force_n > limits.force_n || moment_nm > limits.moment_nm)
      return KrcBreach{KrcRule::TorqueLimit,
                       fmt::format("the tool asked for {:.1f} N and {:.1f} N m (limits {:.0f} N, {:.0f} N m)",
                                   force_n, moment_nm, limits.force_n, limits.moment_nm)};
  }
  return std::nullopt;
}

std::optional<KrcBreach> check_flags_fit(const KrcCommand& c, FriControl control) {
  if ((c.flags & ~flags_of(control)) == 0) return std::nullopt;
  return KrcBreach{KrcRule::FlagsDoNotFit, fmt::format("flags 0x{:04X} do not fit {}, which takes 0x{:04X}",
                                                       c.flags, words(control), flags_of(control))};
}

}  // namespace

KrcLimits::KrcLimits() {
  position_rad << 170, 120, 170, 120, 170, 120, 170;
  velocity_rad_s << 120, 120, 160, 160, 250, 220, 220;
  acceleration_rad_s2 << 1200, 1200, 1600, 1600, 2500, 4400, 4400;
  torque_nm << 176, 176, 100, 100, 100, 38, 38;
  position_rad *= hal::kRadPerDeg;
  velocity_rad_s *= hal::kRadPerDeg;
  acceleration_rad_s2 *= hal::kRadPerDeg;
}

std::string_view name(KrcRule rule) {
  static constexpr std::array<std::string_view, kKrcRules> kNames{"pose-mismatch",
                                                                  "frame-mismatch",
                                                                  "torque-not-initialised",
                                                                  "wrench-not-initialised",
                                                                  "flags-do-not-fit",
                                                                  "flags-changed",
                                                                  "step-too-large",
                                                                  "frame-step-too-large",
                                                                  "position-limit",
                                                                  "gain-out-of-range",
                                                                  "not-finite",
                                                                  "torque-limit",
                                                                  "missed-answers",
                                                                  "quality-lost",
                                                                  "moved-without-power",
                                                                  "bad-datagram"};
  return kNames[static_cast<std::size_t>(rule)];
}

std::string joint_name(int joint) {
  return fmt::format("A{}", joint + 1);
}

Vector6 usual_order(const Float6& w) {
  Vector6 v;
  v << w[0], w[1], w[2], w[5], w[4], w[3];
  return v;
}

Float6 wire_order(const Vector6& v) {
  const auto f = [&](int i) { return static_cast<float>(v[i]); };
  return {f(0), f(1), f(2), f(5), f(4), f(3)};
}

hal::JointVector joints_of(const Float7& wire) {
  hal::JointVector v;
  for (int i = 0; i < kArmJoints; ++i) v[i] = static_cast<double>(wire[static_cast<std::size_t>(i)]);
  return v;
}

Float7 wire_joints(const hal::JointVector& joints) {
  Float7 wire{};
  for (int i = 0; i < kArmJoints; ++i) wire[static_cast<std::size_t>(i)] = static_cast<float>(joints[i]);
  return wire;
}

std::optional<hal::Pose> frame_of(const Float12& wire) {
  if (!finite(wire)) return std::nullopt;
  hal::Pose X = hal::Pose::Identity();
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 4; ++column)
      X.matrix()(row, column) = static_cast<double>(wire[static_cast<std::size_t>(4 * row + column)]);
  const Eigen::Matrix3d R = X.linear();
  if ((R * R.transpose() - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() > 1e-3 || R.determinant() < 0.0)
    return std::nullopt;
  return X;
}

Float12 wire_frame(const hal::Pose& X) {
  Float12 wire{};
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 4; ++column)
      wire[static_cast<std::size_t>(4 * row + column)] = static_cast<float>(X.matrix()(row, column));
  return wire;
}

std::optional<KrcBreach> check_entry(const KrcCommand& c, const KrcJudgedAt& at, const KrcLimits& limits) {
  if (auto b = check_flags_fit(c, at.control)) return b;
  if (auto b = check_numbers(c)) return b;
  if (auto b = check_gains(c, limits)) return b;
  // the posture of Cartesian impedance may be any
  if (has(c, fri_flag::kJointPosition) && at.control != FriControl::CartesianImpedance) {
    const hal::JointVector off = joints_of(c.q_rad) - at.q_rad;
    for (int i = 0; i < kArmJoints; ++i)
      if (std::abs(off[i]) > limits.entry_pose_rad)
        return KrcBreach{KrcRule::PoseMismatch,
                         fmt::format("FRI interpolation error: joint {} starts {:.4f} rad off the commanded "
                                     "pose (limit {:.4f} rad)",
                                     joint_name(i), std::abs(off[i]), limits.entry_pose_rad)};
  }
  if (auto b = check_positions(c, limits)) return b;
  if (has(c, fri_flag::kCartPosition)) {
    const hal::Pose X = *frame_of(c.X_WT);
    const auto near = [&](const hal::Pose& here) {
      const Vector6 off = frame_difference(here, X);
      return off.head<3>().norm() <= limits.entry_position_m && off.tail<3>().norm() <= limits.entry_turn_rad;
    };
    if (!near(at.X_WT) && !near(at.X_WT_measured)) {
      const Vector6 off = frame_difference(at.X_WT_measured, X);
      return KrcBreach{
          KrcRule::FrameMismatch,
          fmt::format("cmd.cartPos not properly initialized: {:.4f} m and {:.4f} rad off the start pose "
                      "(limits {:.4f} m, {:.4f} rad)",
                      off.head<3>().norm(), off.tail<3>().norm(), limits.entry_position_m,
                      limits.entry_turn_rad)};
    }
  }
  if (has(c, fri_flag::kJointTorque)) {
    for (std::size_t i = 0; i < kArmJoints; ++i)
      if (std::abs(c.tau_nm[i]) > limits.entry_torque_nm)
        return KrcBreach{
            KrcRule::TorqueNotInitialised,
            fmt::format("cmd.addJntTrq not properly initialized: joint {} starts with {:.2f} N m "
                        "(limit {:.1f} N m)",
                        joint_name(static_cast<int>(i)), c.tau_nm[i], limits.entry_torque_nm)};
  }
  if (has(c, fri_flag::kTcpWrench)) {
    const Vector6 wrench = usual_order(c.wrench);
    if (wrench.head<3>().norm() > limits.entry_force_n || wrench.tail<3>().norm() > limits.entry_moment_nm)
      return KrcBreach{
          KrcRule::WrenchNotInitialised,
          fmt::format("cmd.addTcpFT not properly initialized: starts with {:.2f} N and {:.2f} N m "
                      "(limits {:.1f} N, {:.1f} N m)",
                      wrench.head<3>().norm(), wrench.tail<3>().norm(), limits.entry_force_n,
                      limits.entry_moment_nm)};
  }
  return std::nullopt;
}

std::optional<KrcBreach> check_command(const KrcCommand& c, const KrcJudgedAt& at, const KrcLimits& limits) {
  if (c.flags != at.flags)
    return KrcBreach{
        KrcRule::FlagsChanged,
        fmt::format("cmdFlags changed during cmd mode, from 0x{:04X} to 0x{:04X}", at.flags, c.flags)};
  if (auto b = check_numbers(c)) return b;
  if (auto b = check_gains(c, limits)) return b;
  if (auto b = check_positions(c, limits)) return b;
  if (auto b = check_steps(c, at, limits)) return b;
  return check_torques(c, at, limits);
}

}  // namespace colift::sim_hal
