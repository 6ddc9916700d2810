#include "tools/telemetry/mcap/mcap_decode.hpp"

#include "tools/telemetry/mcap/byte_io.hpp"
#include "tools/telemetry/mcap/mcap_encode.hpp"

namespace colift::telemetry {
namespace {

std::string text(ByteReader& r) {
  return std::string(r.text());
}

bool text_map(ByteReader& r, std::map<std::string, std::string>& map) {
  ByteReader inner(r.text());
  while (inner.ok() && inner.left() > 0) {
    std::string key = text(inner), value = text(inner);
    if (inner.ok()) map[std::move(key)] = std::move(value);
  }
  return r.ok() && inner.ok();
}

bool count_map(ByteReader& r, std::map<std::uint16_t, std::uint64_t>& map) {
  ByteReader inner(r.text());
  while (inner.ok() && inner.left() > 0) {
    const std::uint16_t key = inner.u16();
    const std::uint64_t value = inner.u64();
    if (inner.ok()) map[key] = value;
  }
  return r.ok() && inner.ok();
}

template <class T>
std::optional<T> if_good(bool good, T value) {
  if (!good) return std::nullopt;
  return value;
}

}  // namespace

std::optional<FileHeader> decode_header(std::string_view content) {
  ByteReader r(content);
  FileHeader h;
  h.profile = text(r), h.library = text(r);
  return if_good(r.ok(), std::move(h));
}

std::optional<Schema> decode_schema(std::string_view content) {
  ByteReader r(content);
  Schema s;
  s.id = r.u16(), s.name = text(r), s.encoding = text(r), s.data = text(r);
  return if_good(r.ok() && s.id != 0, std::move(s));
}

std::optional<Channel> decode_channel(std::string_view content) {
  ByteReader r(content);
  Channel c;
  c.id = r.u16(), c.schema_id = r.u16(), c.topic = text(r), c.message_encoding = text(r);
  const bool good = text_map(r, c.metadata);
  return if_good(good, std::move(c));
}

std::optional<Message> decode_message(std::string_view content) {
  ByteReader r(content);
  Message m;
  m.channel_id = r.u16(), m.sequence = r.u32(), m.log_time = r.u64(), m.publish_time = r.u64();
  m.data = r.rest();
  return if_good(r.ok(), m);
}

std::optional<ChunkIndex> decode_chunk_index(std::string_view content) {
  ByteReader r(content);
  ChunkIndex i;
  i.start_time = r.u64(), i.end_time = r.u64(), i.offset = r.u64(), i.length = r.u64();
  const bool map = count_map(r, i.message_index_offsets);
  i.message_index_length = r.u64(), i.compression = text(r);
  i.compressed_size = r.u64(), i.uncompressed_size = r.u64();
  return if_good(map && r.ok(), std::move(i));
}

std::optional<AttachmentIndex> decode_attachment_index(std::string_view content) {
  ByteReader r(content);
  AttachmentIndex i;
  i.offset = r.u64(), i.length = r.u64(), i.log_time = r.u64(), i.create_time = r.u64();
  i.data_size = r.u64(), i.name = text(r), i.content_type = text(r);
  return if_good(r.ok(), std::move(i));
}

std::optional<Statistics> decode_statistics(std::string_view content) {
  ByteReader r(content);
  Statistics s;
  s.messages = r.u64(), s.schemas = r.u16(), s.channels = r.u32(), s.attachments = r.u32();
  s.metadata = r.u32(), s.chunks = r.u32(), s.start_time = r.u64(), s.end_time = r.u64();
  const bool map = count_map(r, s.per_channel);
  return if_good(map && s.end_time >= s.start_time, std::move(s));
}

std::optional<Metadata> decode_metadata(std::string_view content) {
  ByteReader r(content);
  Metadata m;
  m.name = text(r);
  const bool map = text_map(r, m.entries);
  return if_good(map, std::move(m));
}

std::optional<MetadataIndex> decode_metadata_index(std::string_view content) {
  ByteReader r(content);
  MetadataIndex i;
  i.offset = r.u64(), i.length = r.u64(), i.name = text(r);
  return if_good(r.ok(), std::move(i));
}

std::optional<ReadAttachment> decode_attachment(std::string_view content) {
  ByteReader r(content);
  ReadAttachment a;
  a.attachment.log_time = r.u64(), a.attachment.create_time = r.u64();
  a.attachment.name = text(r), a.attachment.content_type = text(r);
  a.attachment.data = std::string(r.bytes(r.u64()));
  const std::size_t end = r.at();
  const std::uint32_t crc = r.u32();
  if (!r.ok()) return std::nullopt;
  a.crc_good = crc == 0 || crc == crc32_of(content.substr(0, end));
  return a;
}

std::optional<AttachmentIndex> decode_attachment_head(std::string_view first_bytes) {
  ByteReader r(first_bytes);
  AttachmentIndex i;
  i.log_time = r.u64(), i.create_time = r.u64(), i.name = text(r), i.content_type = text(r);
  i.data_size = r.u64();
  return if_good(r.ok(), std::move(i));
}

std::optional<ChunkHead> decode_chunk_head(std::string_view content) {
  ByteReader r(content);
  ChunkHead h;
  h.start_time = r.u64(), h.end_time = r.u64(), h.uncompressed_size = r.u64();
  h.uncompressed_crc = r.u32(), h.compression = text(r), h.records_size = r.u64();
  h.bytes = r.at();
  return if_good(r.ok(), std::move(h));
}

}  // namespace colift::telemetry
