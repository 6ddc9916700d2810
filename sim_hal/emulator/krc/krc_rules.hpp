#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "sim_hal/emulator/krc/plant/krc_limits.hpp"

namespace colift::sim_hal {

/// What a client can do wrong.
enum class KrcRule {
  PoseMismatch,          ///< Into command mode with another joint pose than the commanded one.
  FrameMismatch,         ///< The same for the tool's frame.
  TorqueNotInitialised,  ///< Into command mode with superposed torque.
  WrenchNotInitialised,
  FlagsDoNotFit,  ///< Flags of fields that the active controller does not take.
  FlagsChanged,   ///< In command mode.
  StepTooLarge,   ///< Joint speed.
  FrameStepTooLarge,
  PositionLimit,
  GainOutOfRange,
  NotFinite,
  TorqueLimit,  ///< Spring plus superposed torque (or wrench) beyond what the program allows.
  MissedAnswers,
  QualityLost,
  MovedWithoutPower,
  BadDatagram,
};
inline constexpr int kKrcRules = 16;

/// "pose-mismatch", ...
[[nodiscard]] std::string_view name(KrcRule rule);

struct KrcBreach {
  KrcRule rule;
  std::string reason;
};

/// Names of the axes, in the wire's order: J1 to J7 are A1 A2 E1 A3 A4 A5 A6 on the panel, and A1 to A7 here.
[[nodiscard]] std::string joint_name(int joint);

/// In the usual order x y z, rx ry rz, for a field in the order X Y Z, Rz Ry Rx.
[[nodiscard]] Vector6 usual_order(const Float6& wire);
[[nodiscard]] Float6 wire_order(const Vector6& usual);
[[nodiscard]] hal::JointVector joints_of(const Float7& wire);
[[nodiscard]] Float7 wire_joints(const hal::JointVector& joints);
/// Unset when it is no rotation (to 1e-3) or not finite.
[[nodiscard]] std::optional<hal::Pose> frame_of(const Float12& wire);
[[nodiscard]] Float12 wire_frame(const hal::Pose& X);

/// Where the arm is when a command is judged.
struct KrcJudgedAt {
  FriControl control = FriControl::Position;
  hal::JointVector q_rad;  ///< Commanded in all at entry; last received in command mode.
  hal::Pose X_WT;          ///< The same for the tool.
  hal::JointVector q_measured_rad;
  hal::Pose X_WT_measured;
  std::uint32_t flags = 0;     ///< Frozen at entry.
  double since_s = 0.0;        ///< Time since the command that q_rad is of.
  double safety_limits = 1.0;  ///< Of friStart.
  // what holds where a flag is clear: $STIFFNESS
  hal::JointVector stiffness_nm_rad;
  Vector6 cart_stiffness;
};

/// What keeps a client out of command mode. Looks only at fields whose flag is set.
[[nodiscard]] std::optional<KrcBreach> check_entry(const KrcCommand& command, const KrcJudgedAt& at,
                                                   const KrcLimits& limits);

/// What throws it out again.
[[nodiscard]] std::optional<KrcBreach> check_command(const KrcCommand& command, const KrcJudgedAt& at,
                                                     const KrcLimits& limits);

}  // namespace colift::sim_hal
