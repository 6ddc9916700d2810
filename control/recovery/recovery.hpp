#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "control/arm/arm_commander.hpp"
#include "control/config/config.hpp"
#include "control/monitor/heartbeat.hpp"
#include "control/recovery/assessment.hpp"
#include "control/recovery/recovery_machine.hpp"
#include "control/session/perception_session.hpp"
#include "hal/robot.hpp"
#include "planner/motion/motion_planner.hpp"

namespace colift::control {

/// What the operator answers when he is asked for the next step.
enum class Confirmation { Yes, No, PersonHolds };

/// The operator, as the recovery sees him.
struct RecoveryHooks {
  /// Before each step that moves something: what is about to happen. Before RecoveryStep::TakeOver only
  /// PersonHolds counts.
  std::function<Confirmation(RecoveryStep, const std::string&)> confirm;
  /// In each cycle of a motion of the arm: it may go on (a key is held). The arm stops while it may not.
  std::function<bool()> may_move;
  std::function<bool()> interrupted;
  /// A sentence for the screen; may be empty.
  std::function<void(const std::string&)> say;
};

struct RecoveryRecord {
  struct Change {
    hal::Timestamp at{0};
    RecoveryStep step = RecoveryStep::Assess;
    std::string reason;
  };
  Assessment before;
  std::vector<Change> steps;
  bool recovered = false;      ///< At home, hand open.
  bool device_failed = false;  ///< Arm or hand were not there, or were lost.
  bool interrupted = false;
  bool arm_at_rest = false;  ///< As far as is known.
  std::string reason;
};

struct RecoveryOptions {
  Method method = Method::Fast;
  std::uint64_t seed = 1;
  Drive drive = Drive::InStep;
  hal::JointVector home_rad = hal::JointVector::Zero();
};

/// After a stop: says what state arm, hand and load are in, and brings them in confirmed steps to lowered,
/// released, home. It knows nothing of the run before: only what is measured now. One use, one thread.
class Recovery {
 public:
  /// Robot and rig have to outlive it; `stopwatch` measures computing time only.
  Recovery(hal::Robot& robot, const RigView& rig, const Config& config, const RecoveryOptions& options,
           const hal::Clock& stopwatch);

  /// Opens the devices and assesses; moves after confirmations only. The hand is not initialised when it may
  /// hold something (hal::Hand::configure). Ends with the arm at rest.
  [[nodiscard]] RecoveryRecord run(const RecoveryHooks& hooks);

 private:
  using Event = RecoveryEvent;
  struct Finding {
    Event event;
    std::string detail;
  };

  [[nodiscard]] Finding assess_now();
  /// Plans, asks and begins a step.
  [[nodiscard]] std::optional<Finding> begin();
  [[nodiscard]] std::optional<Finding> begin_step();
  [[nodiscard]] std::optional<Finding> stop_pressing();
  [[nodiscard]] std::optional<Finding> cycle();
  /// Begins a cycle of the arm. A finding: who is lost, or that the operator wants to end.
  [[nodiscard]] std::optional<Finding> read_devices();
  [[nodiscard]] std::optional<Finding> work();
  void apply(const Finding& finding);
  [[nodiscard]] std::string announcement() const;

  [[nodiscard]] std::optional<Finding> lower();
  [[nodiscard]] std::optional<Finding> take_over();
  [[nodiscard]] std::optional<Finding> release();
  [[nodiscard]] std::optional<Finding> move(Event arrived);
  void lower_on();
  /// The arm stops while it may not move, and continues where it stopped.
  [[nodiscard]] bool pausing();
  [[nodiscard]] hal::Result<planner::Trajectory> draw_back_path() const;
  /// Around what the camera observes, or else straight.
  [[nodiscard]] std::optional<Finding> prepare_home();
  [[nodiscard]] bool set_home(const planner::Trajectory& planned);
  [[nodiscard]] planner::MotionLimits limits() const;
  [[nodiscard]] bool ended() const { return is_end(step_); }
  [[nodiscard]] bool last_attempt() const { return attempt_ >= config_.recovery.attempts; }
  [[nodiscard]] double in_step_s() const { return hal::seconds(now_ - since_); }

  hal::Robot& robot_;
  RigView rig_;
  Config config_;
  RecoveryOptions options_;
  const hal::Clock& stopwatch_;
  planner::ArmGeometry geometry_;
  ArmCommander arm_;
  const RecoveryHooks* hooks_ = nullptr;

  RecoveryRecord record_;
  RecoveryStep step_ = RecoveryStep::Assess;
  hal::Timestamp began_{0}, now_{0}, read_at_{0}, since_{0}, unsupported_at_{0}, hand_at_{0};
  std::optional<hal::Timestamp> not_commanded_since_, refused_since_;
  std::uint64_t refused_commands_ = 0;
  std::optional<hal::HandState> hand_;
  double load_before_n_ = 0.0;
  bool arm_started_ = false, paused_ = false;
  int attempt_ = 1;            ///< Of this step.
  bool person_holds_ = false;  ///< As the operator says.
  bool presses_ = false;       ///< Lowered as far as it may press; waits whether that stays.
  planner::Trajectory home_;
  bool planned_ = false;  ///< home_ is collision-free, as far as the camera observes.
  BeatMonitor arm_thread_;
};

}  // namespace colift::control
