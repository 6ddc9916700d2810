#pragma once

#include <catch2/catch.hpp>
#include <cmath>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "tests/unit/tools/telemetry/disk.hpp"
#include "tools/telemetry/mcap/mcap_chunk.hpp"
#include "tools/telemetry/mcap/mcap_writer.hpp"

namespace colift::tests {

/// A message of a recording that is made up.
struct MadeMessage {
  std::string topic;
  double t_s = 0.0;
  std::string data;
  std::string encoding = "json";
};

struct MadeRecording {
  std::vector<MadeMessage> messages;
  std::string config_yaml = {};
  std::string outcome = "lifted";  ///< Empty: it ends before the run.
  std::string started = "2026-01-02T03:04:05Z";
};

/// The bytes of an MCAP file with those messages in their order.
inline std::string bytes_of(const MadeRecording& recording) {
  Disk disk;
  telemetry::McapWriter writer(std::make_unique<DiskSink>(disk));
  REQUIRE(writer.begin("", "test"));
  REQUIRE(writer.attach({0, 0, "config.yaml", "application/yaml", recording.config_yaml}));
  REQUIRE(writer.add(telemetry::Metadata{
      "colift.run", {{"seed", "7"}, {"method", "fast"}, {"started", recording.started}}}));
  if (!recording.outcome.empty())
    REQUIRE(writer.add(
        telemetry::Metadata{"colift.result", {{"outcome", recording.outcome}, {"because", "why"}}}));
  std::map<std::uint16_t, telemetry::Channel> channels;
  std::map<std::string, std::uint16_t> ids;
  telemetry::ChunkBuilder builder(0);
  std::uint32_t count = 0;
  for (const MadeMessage& m : recording.messages) {
    const auto [id, is_new] = ids.emplace(m.topic, static_cast<std::uint16_t>(ids.size() + 1));
    if (is_new) channels[id->second] = {id->second, 0, m.topic, m.encoding, {}};
    const auto at = static_cast<std::uint64_t>(std::llround(1e9 * m.t_s));
    builder.add(nullptr, channels[id->second], {id->second, ++count, at, at, m.data});
  }
  REQUIRE(writer.add(builder.close(), {}, channels));
  REQUIRE(writer.finish());
  return disk.bytes;
}

}  // namespace colift::tests
