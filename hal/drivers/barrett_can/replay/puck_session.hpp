#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "hal/can_log/candump.hpp"
#include "hal/drivers/barrett_can/pucks/puck_codec.hpp"

namespace colift::hal::barrett {

/// A question to one puck, with the frames that answer it: one, or the five of a full tactile scan.
struct PuckAnswer {
  Puck puck{};
  std::array<std::uint32_t, kTactileRows> frames{};  ///< Indices into the log's frames.
  std::uint8_t count = 0;
};

/// What the host said in one frame.
struct PuckRequest {
  std::uint32_t frame = 0;  ///< Index into the log's frames.
  Request says;
  std::vector<PuckAnswer> answers;  ///< Of whom it was asked; none for a setting, but of TACT.
};

/// A log in the words of the pucks' protocol.
struct PuckSession {
  std::vector<PuckRequest> requests;   ///< Of the host whose log it is, in the order of time.
  std::vector<std::uint32_t> unasked;  ///< Frames of pucks that answer nothing that was asked.
  std::vector<std::uint32_t> others;   ///< What other hosts and devices said, and what answers them.
};

/// Pairs questions and answers: an answer belongs to the oldest question of its puck and property that has
/// none, no older than half a second, and the rest of a scan to what its first frame answers. Without
/// directions in the log, whatever node 0 says is the host's.
[[nodiscard]] PuckSession read_puck_session(const std::vector<CandumpFrame>& frames);

/// "F1: MT = 2200", "hand: P?".
[[nodiscard]] std::string describe(const Request& request);
[[nodiscard]] std::string property_word(Property property);

/// What an answer says of which property; nullopt for what is none. Scans are TACT without a value.
struct AnswerValue {
  Puck puck{};
  Property property{};
  std::optional<std::int32_t> value;
  bool begins_scan = true, ends_scan = true;  ///< Of a full scan only its first and its last frame do.
};
[[nodiscard]] std::optional<AnswerValue> read_answer(const CanFrame& frame);

}  // namespace colift::hal::barrett
