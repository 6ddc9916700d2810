#pragma once

#include <optional>
#include <string>

#include "control/task/task_context.hpp"

namespace colift::control {

/// The job's own thread, as the arm's saw it. An arm that moves stops by itself when this thread is late
/// (ArmController::heed_task); here, in the cycles after it, it is decided whether the job goes on: after a
/// short standstill, once this thread has run in time for a while and a new picture came; else it ends.
class StallSupervisor {
 public:
  explicit StallSupervisor(TaskContext& context) : c_(context) {}

  /// Once in each cycle, when arm and camera have been read.
  void read();

  /// The standstill was too long, or there were too many: why. Empty: neither.
  [[nodiscard]] const std::string& fault() const { return fault_; }
  /// The arm has stopped by itself and may not continue yet.
  [[nodiscard]] bool waiting() const { return stalled_at_.has_value(); }
  /// Whether the arm may continue since the last call.
  [[nodiscard]] bool take_recovery();

 private:
  TaskContext& c_;
  std::uint32_t stalls_ = 0;
  hal::Timestamp read_at_{0}, in_time_since_{0};
  std::optional<hal::Timestamp> stalled_at_;
  bool recovered_ = false;
  std::string fault_;
};

}  // namespace colift::control
