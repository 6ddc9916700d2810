#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "hal/drivers/kuka_fri/fri_arm.hpp"
#include "hal/guards/guarded_arm.hpp"
#include "hal/guards/t1_profile.hpp"
#include "hal/os/realtime.hpp"
#include "hal/robot_model/robot_model.hpp"

namespace colift::tools {

/// Whether a KRL program of CoLift's own kind is seen to run: it repeats the heartbeat that it hears, several
/// times in kBeatWatch_s.
class ProgramMonitor {
 public:
  static constexpr double kBeatWatch_s = 0.6;

  /// At any rate, with the time since the start.
  void note(const hal::FriMeasurement& m, double t_s);
  [[nodiscard]] bool heart_beats() const { return changed_s_ && silent_s() < kBeatWatch_s; }
  /// Since the last beat; without one, since the first measurement.
  [[nodiscard]] double silent_s() const { return last_s_ - changed_s_.value_or(first_s_); }

 private:
  bool any_ = false;
  std::int32_t beat_ = 0;
  double first_s_ = 0.0, last_s_ = 0.0;
  std::optional<double> changed_s_;
};

/// Times from a datagram's arrival to its answer, as they are shown.
struct AnswerSummary {
  struct Bar {
    std::uint64_t up_to_us = 0, count = 0;
  };
  std::uint64_t count = 0, p50_us = 0, p99_us = 0, p999_us = 0, worst_us = 0;
  std::vector<Bar> bars;  ///< One per octave, from the first to the last that is not empty.
};
[[nodiscard]] AnswerSummary summary_of(const hal::AnswerTimes& times);

/// All that is said about the arm at one moment.
struct ArmView {
  hal::FriConfig config;
  hal::FriStatus status;
  hal::FriMeasurement m;
  hal::SixVector wrench = hal::SixVector::Zero();  ///< On the tool from outside (N, N m).
  AnswerSummary answers;
  ProgramMonitor program;
  hal::RealtimeReport realtime;
  hal::ArmAbilities abilities;    ///< Of the controller, over this driver.
  double limit_margin_deg = 1.0;  ///< Of the guard.
  double at_s = 0.0;              ///< Since the start.
};
[[nodiscard]] ArmView view_of(const hal::FriArm& arm, const ProgramMonitor& program,
                              const hal::RealtimeReport& realtime, double limit_margin_deg, double at_s);

/// KRL's name of a joint, 0 to 6: A1 A2 E1 A3 A4 A5 A6.
[[nodiscard]] std::string_view krl_name(int joint);
[[nodiscard]] std::string_view name_of(hal::FriState state);
[[nodiscard]] std::string_view name_of(hal::FriQuality quality);
[[nodiscard]] std::string_view name_of(hal::FriControl control);
/// "A2, A4", "none" without a bit.
[[nodiscard]] std::string joints_in(std::uint16_t bits);
/// What the KRL program says of itself, for the script that is expected.
[[nodiscard]] std::string program_text(const ArmView& view);

/// Measured joints (rad), and how far each is from the nearer of its limits.
[[nodiscard]] hal::JointVector measured_rad(const hal::FriMeasurement& m);
[[nodiscard]] hal::JointVector commanded_rad(const hal::FriMeasurement& m);
[[nodiscard]] double to_limit_rad(const hal::RobotModel& model, int joint, double q_rad);

/// One screen: connection, answers, drives, program, joints, wrench, and what stands against command mode.
[[nodiscard]] std::string arm_screen(const ArmView& view, const hal::RobotModel& model);
/// One line of it, for logs.
[[nodiscard]] std::string arm_line(const ArmView& view);
/// The bars, a line each.
[[nodiscard]] std::string histogram_text(const AnswerSummary& answers);
/// Limits of each joint: the model's, what the guard keeps, the profile for T1.
[[nodiscard]] std::string limits_table(const hal::RobotModel& model, const hal::GuardConfig& guard);

using hal::kT1Acceleration_rad_s2, hal::kT1Jerk_rad_s3, hal::kT1Velocity_rad_s;

}  // namespace colift::tools
