#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace colift::tools {

/// How the arm's wire did in one run.
struct ArmLink {
  std::uint64_t cycles = 0, answered = 0, lost = 0;  ///< Datagrams received, answered, and never come.
  struct AnswerTimes {
    std::uint64_t p50 = 0, p99 = 0, p999 = 0, worst = 0;
  } answer_us;  ///< From a datagram's arrival to its answer.
  struct Span {
    double from_s = 0.0, to_s = 0.0;  ///< CLOCK_MONOTONIC.
  };
  std::vector<Span> slow;  ///< Answers that took longer than a cycle; the first 256.
  /// What the controller at the far end says, when it is an emulated one.
  struct Controller {
    std::uint64_t sent = 0, answered = 0, missed = 0;
    int most_missed_in_a_row = 0;
    std::uint64_t late = 0;  ///< Cycles that it began late itself.
    double worst_late_ms = 0.0;
    std::uint64_t missed_in_command = 0;  ///< Of `missed`, while it took commands.
    std::vector<std::string> broken_rules = {};
    std::vector<Span> missed_at = {};            ///< Of missed_in_command; the first 1000.
    std::vector<std::string> left_command = {};  ///< Why it left command mode, each time.
  };
  std::optional<Controller> controller;
};

}  // namespace colift::tools
