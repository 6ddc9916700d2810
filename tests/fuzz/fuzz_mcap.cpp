// A recording from anywhere: read by summary, from the front, by topic; its depth frames decoded.

#include <cstddef>
#include <cstdint>

#include "tools/telemetry/channels/depth_codes.hpp"
#include "tools/telemetry/mcap/mcap_reader.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace colift::telemetry;
  const std::string bytes(reinterpret_cast<const char*>(data), size);
  (void)decode_depth(bytes);
  const auto reader = McapReader::open(source_of(bytes), "fuzz");
  if (!reader) return 0;
  (void)reader->scan();
  for (const auto& a : reader->info().attachments) (void)reader->attachment(a.name);
  for (const auto& m : reader->info().metadata) (void)reader->metadata(m.name);
  auto all = reader->messages();
  while (const auto message = all.next()) (void)decode_depth(message->data);
  std::set<std::string> topics = {"/json"};
  auto some = reader->messages(topics);
  while (some.next()) {
  }
  return 0;
}
