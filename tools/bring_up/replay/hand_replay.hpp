#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "hal/drivers/barrett_can/replay/replay_driver.hpp"

namespace colift::tools {

/// How one property was answered in a session.
struct AnswerForm {
  std::uint64_t asked = 0, answered = 0;  ///< By pucks: a question to the hand is four.
  std::optional<std::int32_t> lowest, highest;
  double median_ms = 0.0, worst_ms = 0.0;  ///< From question to (whole) answer; 0 without any.
};

struct PropertyComparison {
  hal::barrett::Property property{};
  AnswerForm recorded, emulated;
  std::uint64_t differences = 0;
};

/// The recorded questions and settings said to an emulated hand at their times: does it answer in the form of
/// the recorded one?
struct EmulatorReplay {
  std::vector<PropertyComparison> properties;  ///< In the order of their numbers.
  std::vector<hal::barrett::ReplayDifference> differences;
  std::uint64_t more = 0;
  [[nodiscard]] bool equal() const { return differences.empty(); }
};

/// Compared are, for each question, whether it is answered, by which frames (identifiers, lengths), and
/// whether recorded values lie in the range that the emulated hand keeps to; values only where they say what
/// kind of hand it is. The emulated hand is built as the log's answers about firmware, role and group say,
/// and has nothing between its fingers. Of each property at most so many differences are listed, of all 200.
[[nodiscard]] EmulatorReplay replay_emulator(const hal::Candump& log, std::uint64_t most_per_property = 5);

/// `driver` is unset when the log names no calls; `why` says so.
[[nodiscard]] std::string replay_text(const std::optional<hal::DriverReplay>& driver, const std::string& why,
                                      const EmulatorReplay& emulator);
[[nodiscard]] std::string replay_document(const std::string& file,
                                          const std::optional<hal::DriverReplay>& driver,
                                          const std::string& why, const EmulatorReplay& emulator);

}  // namespace colift::tools
