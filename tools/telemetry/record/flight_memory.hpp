#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "tools/telemetry/channels/channels.hpp"
#include "tools/telemetry/mcap/mcap_records.hpp"

namespace colift::telemetry {

/// The last seconds of a run as compressed chunks, and what held before them: of the channels that
/// speak seldom (is_lasting()) the newest message that has aged out, and all changes of state.
/// Without those a file of the last seconds would show a robot in an empty room. For the recorder's thread.
class FlightMemory {
 public:
  /// How much is kept: seconds of the log's time, and bytes, compressed.
  FlightMemory(double seconds, std::size_t bytes) : seconds_(seconds), most_bytes_(bytes) {}

  /// A message that went into the chunk that is being collected.
  void note(Topic topic, std::uint32_t sequence, std::uint64_t log_time, const std::string& payload);
  /// That chunk is closed.
  void keep(std::shared_ptr<const Chunk> chunk);

  /// Oldest first.
  [[nodiscard]] std::vector<std::shared_ptr<const Chunk>> chunks() const;
  /// Calls `visit(topic, sequence, payload)` for what held before the first of them, in the order of their
  /// times.
  void before(
      const std::function<void(Topic, std::uint32_t sequence, const std::string& payload)>& visit) const;

 private:
  struct Said {
    Topic topic = Topic::Log;
    std::uint32_t sequence = 0;
    std::uint64_t log_time = 0;
    std::string payload;
  };
  struct Kept {
    std::shared_ptr<const Chunk> chunk;
    std::vector<Said> seldom;
  };
  void forget_oldest();

  double seconds_;
  std::size_t most_bytes_, bytes_ = 0;
  std::deque<Kept> kept_;
  std::vector<Said> collecting_;
  std::map<Topic, Said> newest_;  ///< Of what was forgotten.
  std::deque<Said> changes_;      ///< Likewise.
};

}  // namespace colift::telemetry
