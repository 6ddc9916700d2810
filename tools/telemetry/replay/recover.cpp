#include "tools/telemetry/replay/recover.hpp"

#include "tools/telemetry/mcap/mcap_chunk.hpp"
#include "tools/telemetry/mcap/mcap_writer.hpp"

namespace colift::telemetry {
namespace {

constexpr std::size_t kChunkBytes = 4u << 20;

hal::Result<Recovered> copy(const McapReader& file, std::unique_ptr<ByteSink> sink) {
  // read from the front: the summary of a file that is damaged in the middle knows nothing of it
  const McapInfo info = file.scan();
  McapWriter writer(std::move(sink));
  Recovered out;
  out.damage = info.damage;
  if (auto done = writer.begin(info.profile, info.library); !done) return tl::unexpected(done.error());
  for (const AttachmentIndex& index : info.attachments) {
    const auto attachment = file.attachment(index.name);
    if (!attachment) {
      out.damage.push_back(attachment.error().text());
      continue;
    }
    if (auto done = writer.attach(*attachment); !done) return tl::unexpected(done.error());
    ++out.attachments;
  }
  for (const MetadataIndex& index : info.metadata) {
    const auto metadata = file.metadata(index.name);
    if (!metadata) {
      out.damage.push_back(metadata.error().text());
      continue;
    }
    if (auto done = writer.add(*metadata); !done) return tl::unexpected(done.error());
    ++out.metadata;
  }
  ChunkBuilder builder;
  const auto close = [&]() -> hal::Result<> {
    if (builder.empty()) return {};
    return writer.add(builder.close(), info.schemas, info.channels);
  };
  auto cursor = file.messages();
  while (const auto message = cursor.next()) {
    const auto channel = info.channels.find(message->channel_id);
    if (channel == info.channels.end()) {
      if (out.damage.size() < 40) out.damage.push_back("a message of an unknown channel is left out");
      continue;
    }
    const auto schema = info.schemas.find(channel->second.schema_id);
    builder.add(schema == info.schemas.end() ? nullptr : &schema->second, channel->second, *message);
    ++out.messages;
    if (builder.size() >= kChunkBytes)
      if (auto done = close(); !done) return tl::unexpected(done.error());
  }
  if (auto done = close(); !done) return tl::unexpected(done.error());
  if (auto done = writer.finish(); !done) return tl::unexpected(done.error());
  out.bytes = writer.size();
  return out;
}

}  // namespace

hal::Result<Recovered> recover(const McapReader& file, const std::filesystem::path& to) {
  // under its own name only when it is whole: a full disk leaves nothing behind that looks like a recording
  std::filesystem::path part = to;
  part += ".part";
  auto sink = create_file(part);
  if (!sink) return tl::unexpected(sink.error());
  auto done = copy(file, std::move(*sink));
  std::error_code error;
  if (done) std::filesystem::rename(part, to, error);
  if (error)
    done = hal::failure(hal::ErrorCode::BadInput, to.string(), "cannot be written: " + error.message());
  if (!done) std::filesystem::remove(part, error);
  return done;
}

}  // namespace colift::telemetry
