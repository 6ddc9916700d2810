#pragma once

#include <map>
#include <optional>
#include <set>
#include <vector>

#include "hal/types/time.hpp"
#include "tools/telemetry/channels/channels.hpp"
#include "tools/telemetry/mcap/mcap_reader.hpp"

namespace colift::telemetry {

/// Hands messages of a recording to sinks as they stand in it, in the order of the file.
class Playback {
 public:
  /// Of these topics, as far as the recording has them. File and sinks have to outlive it.
  Playback(const McapReader& file, const std::set<Topic>& topics, std::vector<TelemetrySink*> sinks);

  /// When the next message was recorded (robot's clock); nothing at the end.
  [[nodiscard]] std::optional<hal::Timestamp> next_at();
  /// Hands on what was recorded up to then.
  void play(hal::Timestamp until);

 private:
  [[nodiscard]] bool find_next();

  std::map<std::uint16_t, Topic> topics_;  ///< By the recording's channel.
  McapReader::Cursor cursor_;
  std::vector<TelemetrySink*> sinks_;
  std::optional<Message> next_;
  bool ended_ = false;
};

}  // namespace colift::telemetry
