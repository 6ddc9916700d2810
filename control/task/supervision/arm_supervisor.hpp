#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "control/monitor/heartbeat.hpp"
#include "control/task/task_context.hpp"

namespace colift::control {

/// Whether the arm is there. Its driver comes to rest by itself when packets are lost or the quality is gone,
/// and takes commands again by itself, from the measured pose, when the link has healed: for so long the job
/// waits. What needs a person (command mode left, drives off, a fault) is reported at once as lost().
class ArmSupervisor {
 public:
  explicit ArmSupervisor(TaskContext& context) : c_(context) {}

  /// Begins a cycle of the arm: advances the job's time, reads the view. `slow_reason`: why the arm was asked
  /// to go slowly; empty: it was not.
  void read(const std::string& slow_reason);

  [[nodiscard]] bool lost() const { return lost_; }
  [[nodiscard]] const std::string& fault() const { return fault_; }
  /// The controller takes no commands for the moment.
  [[nodiscard]] bool interrupted() const { return interrupted_since_.has_value(); }
  /// Whether the arm's cycle began anew since the last call: whatever it was doing was cut off.
  [[nodiscard]] bool take_restart();

 private:
  void not_commanded();
  /// The arm's own thread runs; else it is reported as lost.
  [[nodiscard]] bool thread_runs();

  TaskContext& c_;
  bool had_command_ = false, lost_ = false, restarted_ = false, slow_ = false;
  std::optional<hal::Timestamp> interrupted_since_;
  std::uint32_t starts_ = 0;  ///< Of the arm's cycle, as far as is known.
  std::string fault_;
  BeatMonitor thread_;
};

}  // namespace colift::control
