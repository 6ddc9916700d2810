// Reads a recording of colift run: what is in it, how the task went, and the first depth frame.
//
//   build/colift run --seed 7 --record run.mcap
//   build/example_08_read_a_recording run.mcap

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tools/telemetry/channels/recorded_frame.hpp"
#include "tools/telemetry/mcap/mcap_reader.hpp"

int main(int argc, char** argv) {
  using namespace colift;
  if (argc != 2) return fmt::print(stderr, "which recording? {} run.mcap\n", argv[0]), 2;
  auto file = telemetry::open_file(argv[1]);
  if (!file) return fmt::print(stderr, "{}\n", file.error().text()), 2;
  const auto recording = telemetry::McapReader::open(std::move(*file), argv[1]);
  if (!recording) return fmt::print(stderr, "{}\n", recording.error().text()), 2;

  const telemetry::McapInfo& info = recording->info();
  const auto seconds = [&](std::uint64_t time_ns) {
    return 1e-9 * static_cast<double>(time_ns - info.statistics.start_time);
  };
  fmt::print("{} messages in {:.1f} s, {}\n", info.statistics.messages, seconds(info.statistics.end_time),
             info.complete ? "complete" : "cut");
  for (const auto& [id, channel] : info.channels) {
    const auto count = info.statistics.per_channel.find(id);
    fmt::print("  {:22} {:6}  {}\n", channel.topic,
               count == info.statistics.per_channel.end() ? 0 : count->second,
               info.schemas.contains(channel.schema_id) ? info.schemas.at(channel.schema_id).name
                                                        : channel.message_encoding);
  }
  for (const std::string& damage : info.damage) fmt::print("damage: {}\n", damage);

  // messages are JSON, but for the images; a damaged file is read as far as it goes
  int changes = 0;
  auto states = recording->messages({"/task/change"});
  while (const auto message = states.next()) {
    fmt::print("{:6.2f} s  {}\n", seconds(message->log_time), message->data);
    ++changes;
  }

  // a frame is what describes it, and its images
  auto parts = recording->messages({"/camera/frame", "/camera/color", "/camera/depth"});
  telemetry::FrameJoiner joiner;
  std::optional<telemetry::EncodedFrame> first;
  while (!first) {
    const auto part = parts.next();
    if (!part) return fmt::print(stderr, "no depth frame in it\n"), 1;
    first = joiner.add(info.channels.at(part->channel_id).topic, part->data);
  }
  const auto frame = telemetry::decode_frame(*first);
  if (!frame) return fmt::print(stderr, "{}\n", frame.error().text()), 1;
  const auto& depth_m = frame->frame.depth_m;
  const auto measured = std::count_if(depth_m.begin(), depth_m.end(), [](float d) { return !std::isnan(d); });
  fmt::print("frame {}: {} x {} pixels, {:.0f} % with depth, {} bytes\n", frame->number,
             frame->frame.intrinsics.width, frame->frame.intrinsics.height,
             100.0 * static_cast<double>(measured) / static_cast<double>(depth_m.size()),
             first->depth.size());
  return changes > 0 ? 0 : 1;
}
