#pragma once

#include <cstddef>
#include <optional>
#include <string>

#include "control/task/task_context.hpp"

namespace colift::control {

/// Whether the hand answers, and what it warns of.
class HandSupervisor {
 public:
  explicit HandSupervisor(TaskContext& context) : c_(context) {}

  void start() { answered_at_ = c_.now; }
  void read();

  [[nodiscard]] bool lost() const { return lost_; }
  [[nodiscard]] const std::string& fault() const { return fault_; }
  /// Of a hand that works all the same; mostly empty.
  [[nodiscard]] const std::string& warning() const { return warning_; }
  /// The one puck that the last error was of, while the others answer: 0 to 2 a finger, 3 the spread.
  [[nodiscard]] const std::optional<std::size_t>& silent_puck() const { return silent_puck_; }
  /// Goes on without that puck; the others are to answer from now on.
  void continue_without_puck();

 private:
  TaskContext& c_;
  hal::Timestamp answered_at_{0};
  bool lost_ = false;
  std::string fault_, warning_;
  std::optional<std::size_t> silent_puck_;
};

}  // namespace colift::control
