#include "tools/telemetry/mcap/mcap_encode.hpp"

#include <zlib.h>

#include <algorithm>

#include "tools/telemetry/mcap/byte_io.hpp"

namespace colift::telemetry {
namespace {

/// Maps and arrays carry the length of their bytes before them.
template <class Fill>
void sized(ByteWriter& out, Fill fill) {
  std::string inner;
  ByteWriter w(inner);
  fill(w);
  out.text(inner);
}

void text_map(ByteWriter& out, const std::map<std::string, std::string>& map) {
  sized(out, [&](ByteWriter& w) {
    for (const auto& [key, value] : map) w.text(key), w.text(value);
  });
}

void count_map(ByteWriter& out, const std::map<std::uint16_t, std::uint64_t>& map) {
  sized(out, [&](ByteWriter& w) {
    for (const auto& [key, value] : map) w.u16(key), w.u64(value);
  });
}

}  // namespace

std::uint32_t crc32_of(std::string_view bytes, std::uint32_t before) {
  auto crc = static_cast<uLong>(before);
  while (!bytes.empty()) {
    const std::size_t some = std::min<std::size_t>(bytes.size(), 1u << 30);
    crc = ::crc32(crc, reinterpret_cast<const Bytef*>(bytes.data()), static_cast<uInt>(some));
    bytes.remove_prefix(some);
  }
  return static_cast<std::uint32_t>(crc);
}

std::string record(Op op, std::string_view content) {
  std::string out;
  out.reserve(kRecordHead + content.size());
  ByteWriter w(out);
  w.u8(static_cast<std::uint8_t>(op));
  w.u64(content.size());
  w.bytes(content);
  return out;
}

std::string encode_header(std::string_view profile, std::string_view library) {
  std::string c;
  ByteWriter w(c);
  w.text(profile), w.text(library);
  return record(Op::Header, c);
}

std::string encode(const Schema& s) {
  std::string c;
  ByteWriter w(c);
  w.u16(s.id), w.text(s.name), w.text(s.encoding), w.text(s.data);
  return record(Op::Schema, c);
}

std::string encode(const Channel& channel) {
  std::string c;
  ByteWriter w(c);
  w.u16(channel.id), w.u16(channel.schema_id), w.text(channel.topic), w.text(channel.message_encoding);
  text_map(w, channel.metadata);
  return record(Op::Channel, c);
}

std::string encode(const Message& m) {
  std::string c;
  c.reserve(22 + m.data.size());
  ByteWriter w(c);
  w.u16(m.channel_id), w.u32(m.sequence), w.u64(m.log_time), w.u64(m.publish_time), w.bytes(m.data);
  return record(Op::Message, c);
}

std::string encode(const Chunk& chunk) {
  std::string c;
  c.reserve(64 + chunk.records.size());
  ByteWriter w(c);
  w.u64(chunk.start_time), w.u64(chunk.end_time), w.u64(chunk.uncompressed_size);
  w.u32(chunk.uncompressed_crc), w.text(chunk.compression);
  w.u64(chunk.records.size()), w.bytes(chunk.records);
  return record(Op::Chunk, c);
}

std::string encode_message_index(std::uint16_t channel, const MessageIndex& index) {
  std::string c;
  ByteWriter w(c);
  w.u16(channel);
  sized(w, [&](ByteWriter& inner) {
    for (const auto& [time, offset] : index) inner.u64(time), inner.u64(offset);
  });
  return record(Op::MessageIndex, c);
}

std::string encode(const ChunkIndex& i) {
  std::string c;
  ByteWriter w(c);
  w.u64(i.start_time), w.u64(i.end_time), w.u64(i.offset), w.u64(i.length);
  count_map(w, i.message_index_offsets);
  w.u64(i.message_index_length), w.text(i.compression), w.u64(i.compressed_size), w.u64(i.uncompressed_size);
  return record(Op::ChunkIndex, c);
}

std::string encode(const Attachment& a) {
  std::string c;
  c.reserve(64 + a.data.size());
  ByteWriter w(c);
  w.u64(a.log_time), w.u64(a.create_time), w.text(a.name), w.text(a.content_type);
  w.u64(a.data.size()), w.bytes(a.data);
  w.u32(crc32_of(c));
  return record(Op::Attachment, c);
}

std::string encode(const AttachmentIndex& i) {
  std::string c;
  ByteWriter w(c);
  w.u64(i.offset), w.u64(i.length), w.u64(i.log_time), w.u64(i.create_time), w.u64(i.data_size);
  w.text(i.name), w.text(i.content_type);
  return record(Op::AttachmentIndex, c);
}

std::string encode(const Metadata& m) {
  std::string c;
  ByteWriter w(c);
  w.text(m.name);
  text_map(w, m.entries);
  return record(Op::Metadata, c);
}

std::string encode(const MetadataIndex& i) {
  std::string c;
  ByteWriter w(c);
  w.u64(i.offset), w.u64(i.length), w.text(i.name);
  return record(Op::MetadataIndex, c);
}

std::string encode(const Statistics& s) {
  std::string c;
  ByteWriter w(c);
  w.u64(s.messages), w.u16(s.schemas), w.u32(s.channels), w.u32(s.attachments), w.u32(s.metadata);
  w.u32(s.chunks), w.u64(s.start_time), w.u64(s.end_time);
  count_map(w, s.per_channel);
  return record(Op::Statistics, c);
}

std::string encode_summary_offset(Op group, std::uint64_t start, std::uint64_t length) {
  std::string c;
  ByteWriter w(c);
  w.u8(static_cast<std::uint8_t>(group)), w.u64(start), w.u64(length);
  return record(Op::SummaryOffset, c);
}

std::string encode_data_end(std::uint32_t crc) {
  std::string c;
  ByteWriter w(c);
  w.u32(crc);
  return record(Op::DataEnd, c);
}

}  // namespace colift::telemetry
