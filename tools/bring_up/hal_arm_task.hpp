#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "control/config/setpoint_limits.hpp"
#include "control/config/task_config.hpp"
#include "hal/arm.hpp"
#include "hal/guards/guarded_arm.hpp"
#include "hal/robot_model/load_estimate.hpp"
#include "hal/robot_model/robot_model.hpp"
#include "hal/types/latest_value.hpp"
#include "tools/bring_up/control/switch_task.hpp"
#include "tools/bring_up/hal_arm_view.hpp"
#include "tools/bring_up/task_outcome.hpp"

namespace colift::tools {

/// What the arm is asked to do during bring-up.
struct ArmTask {
  enum class Kind {
    Watch,   ///< Nothing moves and nothing is asked for.
    Hold,    ///< Command mode, the measured pose.
    Move,    ///< Command mode, one joint by an angle.
    Load,    ///< Command mode, ten poses about the present one, in each of which the load is measured; then
             ///< back.
    Switch,  ///< Command mode in one control strategy after the other, the measured pose in each.
  };
  Kind kind = Kind::Watch;
  double for_s = std::numeric_limits<double>::infinity();  ///< Of watching or holding.
  double stiffness_nm_rad = 1000.0;
  double damping_ratio = 0.7;
  std::string control = "joint_impedance";  ///< Strategy that is commanded.
  std::vector<std::string> controls;        ///< Of Kind::Switch, in their order; `for_s` each.
  int joint = 0;                            ///< To move, from 0.
  double by_rad = 0.0, speed_rad_s = 0.0;
  double acceleration_rad_s2 = kT1Acceleration_rad_s2, jerk_rad_s3 = kT1Jerk_rad_s3;
  control::TaskConfig config;         ///< Of these the set points: contact, warnings of the controller.
  control::SetpointLimits setpoints;  ///< Below these, whatever the task asks for.
};

/// How far it is; leaves the cycle as plain numbers.
struct ArmProgress {
  enum class Phase : std::uint8_t { Opening, Watching, Asking, Commanding, Stopping, Leaving, Over };
  Phase phase = Phase::Opening;
  double in_phase_s = 0.0;
  double done = 0.0;  ///< Part of a motion, 0 to 1.
  std::array<double, hal::kArmJoints> commanded_rad{}, measured_rad{};
};
[[nodiscard]] std::string_view to_string(ArmProgress::Phase phase);

/// How it ended.
struct ArmTaskEnd {
  using How = TaskOutcome;
  How how = How::Done;
  std::string reason;  ///< Empty when done.
  bool commanded = false;
  double commanded_s = 0.0;
  hal::JointVector start_rad = hal::JointVector::Zero();    ///< Measured when commands began.
  hal::JointVector end_rad = hal::JointVector::Zero();      ///< Measured at the last command.
  hal::JointVector goal_rad = hal::JointVector::Zero();     ///< Commanded last.
  hal::JointVector drift_rad = hal::JointVector::Zero();    ///< Greatest distance of measured from commanded.
  hal::JointVector external_nm = hal::JointVector::Zero();  ///< Greatest magnitude.
  std::uint64_t cycles = 0, bad_cycles = 0, restarts = 0;
  std::vector<hal::LoadSample> load_samples;  ///< One for each pose of Kind::Load.
  std::optional<hal::LoadError> load;
  hal::FlangeLoad expected_load;     ///< The model's hand.
  std::vector<SwitchStep> switches;  ///< Of Kind::Switch.
};

/// Runs the task in the calling thread, which is then the arm's: opens the arm, for all but watching gets
/// command mode, commands one set point per cycle, comes to rest and leaves. `arm` is the guarded one.
/// `interrupted` ends it from any thread or signal; while activate() waits, arm.stop() is needed as well.
/// `why` says why commands are not taken, when the arm can tell; else errors speak for themselves.
struct ArmTaskHooks {
  const std::atomic<bool>& interrupted;
  hal::LatestValue<ArmProgress>& progress;
  std::function<std::string()> why;
};
[[nodiscard]] ArmTaskEnd run_arm_task(hal::Arm& arm, const hal::RobotModel& model,
                                      const hal::GuardConfig& guard, const ArmTask& task,
                                      const hal::Clock& clock, const ArmTaskHooks& hooks);

/// Why a joint at `q_rad` may not be moved by `by_rad`; empty when it may. Limits of the model with the
/// guard's margin.
[[nodiscard]] std::string beyond_limits(const hal::RobotModel& model, const hal::GuardConfig& guard,
                                        int joint, double q_rad, double by_rad);

/// What was done, in sentences.
[[nodiscard]] std::string task_summary(const ArmTask& task, const ArmTaskEnd& end);

}  // namespace colift::tools
