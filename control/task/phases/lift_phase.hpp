#pragma once

#include <cmath>
#include <optional>

#include "control/lift/load_balance.hpp"
#include "control/lift/steady_load.hpp"
#include "control/task/let_go_monitor.hpp"
#include "control/task/lift_evidence.hpp"
#include "control/task/object_monitor.hpp"
#include "control/task/task_context.hpp"

namespace colift::control {

/// Lift, Hold and Lower: the object is in the air.
class LiftPhase {
 public:
  LiftPhase(TaskContext& context, ObjectMonitor& object, LetGoMonitor& partner, LiftEvidence& evidence)
      : c_(context), object_(object), partner_(partner), evidence_(evidence) {}

  void begin_lift(Task from);
  [[nodiscard]] std::optional<TaskEvent> lift();
  void begin_hold();
  [[nodiscard]] std::optional<TaskEvent> hold();
  /// Writes the summary of the hold into the record, too.
  void begin_lower();
  [[nodiscard]] std::optional<TaskEvent> lower();
  /// The robot's share of the weight, newest estimate of the hold; unset where it is not known.
  [[nodiscard]] std::optional<double> share_robot() const { return share_robot_; }

 private:
  /// Starts the arm once that was announced; who follows the partner starts at once.
  [[nodiscard]] bool raised();
  [[nodiscard]] bool lowered();
  /// The commanded height has been reached for a moment.
  [[nodiscard]] bool settled();
  /// The load on the hand has come to rest as well, or had its time to.
  [[nodiscard]] bool load_settled();
  /// A slow mean of the load while the palm stands at the top.
  void start_mean_load();
  void update_mean_load();
  [[nodiscard]] std::optional<TaskEvent> partner_gone_or_lowers();
  /// The hand is closed, and nothing hangs in it any more.
  [[nodiscard]] std::optional<TaskEvent> load_lost();
  /// What lowering has come to: the object stands, met something, or still hangs at the end of the search.
  [[nodiscard]] std::optional<TaskEvent> judge_lowering();
  [[nodiscard]] LiftSummary summary_of_hold() const;
  [[nodiscard]] KnownBefore known_before() const;

  TaskContext& c_;
  ObjectMonitor& object_;
  LetGoMonitor& partner_;
  LiftEvidence& evidence_;
  double lift_s_ = 0.0;                             ///< That this lift takes.
  Task from_ = Task::AwaitReady;                    ///< Where this lift began.
  bool load_steady_ = false;                        ///< When the hold began.
  bool raises_ = false, lowers_ = false;            ///< The arm was started.
  bool partner_lowers_ = false;                     ///< Of his own accord: the arm goes down with him.
  hal::Timestamp his_end_stays_at_{0};              ///< It was last seen where he held it.
  hal::Timestamp updated_at_{0};                    ///< The load, last.
  hal::Timestamp moved_at_{0}, unsupported_at_{0};  ///< The palm; the object without the ground: last time.
  std::optional<double> share_robot_;
  SteadyLoad steady_;             ///< Since the palm came to rest at the top.
  double mean_load_n_ = NAN;      ///< NaN before its first value.
  hal::Timestamp carried_at_{0};  ///< When the hand last carried something.
  bool found_ = false;            ///< ... and has found what bears it.
  bool seeks_ = false;            ///< Goes below where it grasped, to set down what hangs.
};

}  // namespace colift::control
