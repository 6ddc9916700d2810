#pragma once

// Inside of replay: devices that answer as they did. Not for other folders.

#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "hal/robot.hpp"
#include "tools/telemetry/channels/recorded_frame.hpp"
#include "tools/telemetry/mcap/mcap_reader.hpp"
#include "tools/telemetry/record/cycle_inputs.hpp"

namespace colift::telemetry {

/// The inputs of one cycle of the task after the other, with their frames.
class Tape {
 public:
  explicit Tape(const McapReader& file);

  /// Goes on to the next cycle. False at the end; the last cycle stays.
  bool advance();
  [[nodiscard]] bool ended() const { return ended_; }
  [[nodiscard]] const CycleInputs& now() const { return now_; }
  [[nodiscard]] std::uint64_t cycles() const { return cycles_; }
  [[nodiscard]] const std::vector<std::string>& notes() const { return notes_; }

  // The next of each kind in this cycle; nothing when there are no more.
  [[nodiscard]] hal::Timestamp next_clock();
  [[nodiscard]] std::optional<hal::Result<hal::ArmState>> next_arm();
  [[nodiscard]] std::optional<hal::Result<hal::HandState>> next_hand();
  [[nodiscard]] hal::Result<hal::DepthFrame> next_camera();
  [[nodiscard]] hal::Result<> next_answer();
  [[nodiscard]] hal::DeviceHealth next_health();

 private:
  void note(std::string text);

  const std::map<std::uint16_t, Channel>& channels_;
  McapReader::Cursor cursor_;
  FrameJoiner joiner_;
  CycleInputs now_;
  std::map<std::uint64_t, EncodedFrame> frames_;  ///< By number; those of this cycle and not yet asked for.
  std::size_t clock_ = 0, arm_ = 0, hand_ = 0, camera_ = 0, answer_ = 0, health_ = 0;
  hal::Timestamp last_clock_{0};
  hal::DeviceHealth last_health_;
  std::uint64_t cycles_ = 0;
  bool ended_ = false;
  std::vector<std::string> notes_;
};

/// With the first camera and `more_cameras` others.
[[nodiscard]] hal::Robot replayed_robot(Tape& tape, std::size_t more_cameras);

}  // namespace colift::telemetry
