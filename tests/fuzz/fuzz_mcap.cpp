// A recording from anywhere: read by summary, from the front, by topic; its depth frames decoded.

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <set>
#include <string>
#include <string_view>

#include "tools/telemetry/channels/depth_cdt1.hpp"
#include "tools/telemetry/channels/image_message.hpp"
#include "tools/telemetry/channels/recorded_frame.hpp"
#include "tools/telemetry/channels/string_message.hpp"
#include "tools/telemetry/mcap/mcap_reader.hpp"

namespace {

/// As a message of /robot_description: refused, or a text that lies within the bytes.
void read_text(std::string_view bytes) {
  const auto text = colift::telemetry::parse_string(bytes);
  if (text && !text->empty() && (text->data() < bytes.data() || text->end() > bytes.end())) std::abort();
}

/// As a message of /camera/depth: old form, or an image that a frame of 4 x 3 describes.
void decode_image(std::string_view bytes) {
  using namespace colift::telemetry;
  (void)decode_cdt1(bytes);
  if (const auto image = parse_image(bytes)) (void)depth_of(*image);
  colift::hal::DepthFrame small;
  small.intrinsics = {4, 3, 5.0, 5.0, 2.0, 1.5};
  FrameJoiner joiner;
  (void)joiner.add("/camera/frame", bytes);
  (void)joiner.add("/camera/frame", frame_message(0, small));
  (void)joiner.add("/camera/color", bytes);
  if (const auto encoded = joiner.add("/camera/depth", bytes)) (void)decode_frame(*encoded);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace colift::telemetry;
  const std::string bytes(reinterpret_cast<const char*>(data), size);
  decode_image(bytes);
  read_text(bytes);
  const auto reader = McapReader::open(source_of(bytes), "fuzz");
  if (!reader) return 0;
  (void)reader->scan();
  for (const auto& a : reader->info().attachments) (void)reader->attachment(a.name);
  for (const auto& m : reader->info().metadata) (void)reader->metadata(m.name);
  auto all = reader->messages();
  while (const auto message = all.next()) {
    decode_image(message->data);
    read_text(message->data);
  }
  std::set<std::string> topics = {"/json"};
  auto some = reader->messages(topics);
  while (some.next()) {
  }
  return 0;
}
