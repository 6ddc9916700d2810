#pragma once

#include <cmath>
#include <cstdint>
#include <memory>
#include <optional>

#include "control/arm/setpoint_generator.hpp"
#include "control/arm/yield_compensation.hpp"
#include "control/arm/yield_law.hpp"
#include "control/lift/cartesian_impedance.hpp"
#include "control/lift/energy_tank.hpp"
#include "control/lift/lift_controller.hpp"
#include "control/lift/load_estimator.hpp"
#include "control/monitor/force_monitor.hpp"
#include "control/monitor/heartbeat.hpp"
#include "hal/types/short_text.hpp"

namespace colift::control {

/// What the task asks of the arm's cycle.
struct ArmRequest {
  enum class Kind {
    Hold,        ///< Come to rest and stay.
    Follow,      ///< Run along `trajectory`.
    Resume,      ///< Go on along it, with `number` of its speed.
    Back,        ///< Run back along it, with `number` of its speed.
    Slow,        ///< Slower from now on, when `number` is not 0; else no more.
    Scale,       ///< At most `number` of its speed from now on, 0 to 1; 0: stands still where it is.
    Ease,        ///< The palm's set point goes to where the palm stands: no spring presses on the object.
    Unload,      ///< Superpose no torque any more: the hand is empty.
    StartTare,   ///< What is felt from now on ...
    EndTare,     ///< ... until now is nothing.
    StartLift,   ///< The hand has closed here: raise the palm by `number` (m) in `time_s`, in `role`.
    RaiseOn,     ///< Raise it further, to `number` over where the hand closed.
    Stay,        ///< Raise it no further. At once: for a slow lift.
    Lower,       ///< Bring it down again.
    SeePartner,  ///< His end of the object has risen by `number` (m).
    ResumeLift,  ///< Continue the lift that was stopped because the task was late.
    Pause,       ///< Stop a lift where it is, load compensated; RaiseOn or Lower continue it.
    Yield,       ///< Come to rest, then give way to whoever pushes.
    Expect,      ///< From now on the hand's load is `load`.
  };
  Kind kind = Kind::Hold;
  std::uint32_t id = 0;  ///< Counts up; ArmView::answered tells which ones were taken.
  std::shared_ptr<const planner::Trajectory> trajectory{};
  double number = 0.0;
  LiftController::Role role = LiftController::Role::Lead;
  double time_s = 0.0;
  HandLoad load = HandLoad::Empty;
  HandLine line{};  ///< Of StartLift and RaiseOn.
};

/// Whether a request changes what the arm is doing, so that answers about the motion before are void.
[[nodiscard]] bool moves(ArmRequest::Kind kind);

/// What the task knows of the arm after a cycle. Copied without allocation.
struct ArmView {
  hal::ArmState state;
  std::uint32_t answered = 0;  ///< The last request that was taken.

  // of the motion
  hal::JointVector commanded_rad = hal::JointVector::Zero();
  bool running = false;  ///< The controller takes commands.
  bool at_rest = false, done = false;
  double progress = 1.0;
  std::uint32_t starts = 0;
  SetpointGenerator::Blockage blocked;
  bool trajectory_refused = false;  ///< The last trajectory could not be started, or not be taken up again.
  bool slow = false;  ///< Goes slower than planned: the controller warns, or the task asked for it.

  // of the task's thread, where the cycle has one of its own
  bool stalled = false;  ///< The task was late: the arm stopped by itself, until it is asked to move again.
  std::uint32_t stalls = 0;  ///< How often, since the start.
  double stall_s = 0.0;      ///< For how long the task had not run, in the last of them.

  // of what is felt
  std::optional<hal::Wrench> wrench_W;
  double load_n = 0.0;
  hal::Wrench felt_W;       ///< Against the zero of the force monitor.
  ForceFinding force;       ///< That the arm has stopped for, and yields to.
  bool force_quiet = true;  ///< Nothing above a limit is felt now.
  bool load_lost = false;   ///< An arm that yields bore a load, and bears none any more.

  // of the lift
  double height_m = 0.0;
  bool lift_at_rest = false, end_of_reach = false;
  LiftController::Role role = LiftController::Role::Lead;
  bool palm_springs = false;  ///< The palm's impedance was used in the last lift, not the joints'.
  double energy_j = NAN, min_energy_j = NAN;  ///< EnergyTank, since the lift began; NaN before one.

  // of the link
  std::uint64_t cycles = 0, missed = 0;  ///< Since the start.
  int misses = 0;                        ///< In a row, until now.
  bool link_lost = false;                ///< The last error was not a mere miss.
  std::uint64_t refused_commands = 0;    ///< By the last gate or by the controller.
  hal::ShortText fault, refusal;
};

/// Why the arm stopped by itself, with figures.
[[nodiscard]] std::string describe_stall(const ArmView& view);

/// Everything that happens in one cycle of the arm: what it feels, the lift, the motion, the command. One
/// thread; cycle() does not allocate unless something goes wrong.
class ArmController {
 public:
  ArmController(const hal::RobotModel& model, const planner::ArmGeometry& arm, const TaskConfig& task,
                const LoadConfig& load, const SetpointLimits& limits = {},
                const ForceMonitorConfig& force = {.on = false}, const hal::ArmAbilities& abilities = {});

  /// What the controller measured, or why it did not.
  void measured(const hal::Result<hal::ArmState>& state);
  void take(const ArmRequest& request);
  /// Once in each cycle, where the task runs in another thread: how often that has come by. A moving arm
  /// whose task is late (SupervisionConfig::beat_timeout_s) comes to rest on its path and stays; at rest
  /// nobody waits for the task.
  void heed_task(std::uint64_t beats);
  /// The answer to the last cycle; none to one that was missed or whose controller takes no commands.
  [[nodiscard]] std::optional<hal::ImpedanceCommand> command();
  /// What became of it.
  void sent(const hal::Result<>& result);

  /// As it is now. A request is taken into account at once.
  [[nodiscard]] const ArmView& view();

 private:
  /// Once in every cycle. A lift stands still with an arm that is not commanded, and goes on from where it
  /// is.
  void serve_lift();
  void start_lift_time();
  /// Continues a lift that was paused, from where the arm stands.
  void continue_lift();
  void monitor_force();
  /// Makes the palm's springs of the joints', and counts what the arm gives.
  [[nodiscard]] hal::ImpedanceCommand with_palm_springs(const hal::ImpedanceCommand& joints);
  void start_yield();
  void start_compensation();
  void end_yield();
  /// The set point goes to where the palm stands, without torque: no spring pulls it.
  void leave_palm();
  /// An arm that is pushed farther than the band follows: it does not spring back.
  void serve_yield();

  const hal::RobotModel* model_;
  SetpointGenerator setpoints_;
  LoadEstimator load_;
  LiftController lift_;
  CartesianImpedance palm_;
  bool palm_springs_;  ///< The palm's impedance while it carries, not the joints'.
  std::uint32_t palm_starts_ = 0;
  EnergyTank energy_;
  double energy_allowed_j_, energy_band_j_;
  ForceMonitor force_;
  YieldLaw yield_;
  double stiffness_nm_rad_, yield_stiffness_nm_rad_, yield_slope_nm_rad_s_;
  bool yielding_ = false;
  YieldCompensation compensation_;
  hal::JointVector superposed_nm_ = hal::JointVector::Zero();        ///< Before it yielded ...
  hal::JointVector yield_superposed_nm_ = hal::JointVector::Zero();  ///< ... and while it does.
  hal::CycleTime monitor_time_;
  bool lifting_ = false, stopped_by_contact_ = false;
  bool lift_cut_off_ = false;  ///< By a task that was late.
  double beat_timeout_s_;
  BeatMonitor task_beat_;
  std::uint32_t lift_starts_ = 0;  ///< Of the cycle, when the lift began or went on.
  hal::CycleTime lift_time_;
  ArmView view_;
};

}  // namespace colift::control
