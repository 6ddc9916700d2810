#include "tools/telemetry/mcap/mcap_writer.hpp"

#include <algorithm>

#include "tools/telemetry/mcap/byte_io.hpp"
#include "tools/telemetry/mcap/mcap_encode.hpp"

namespace colift::telemetry {

McapWriter::McapWriter(std::unique_ptr<ByteSink> sink) : sink_(std::move(sink)) {}

hal::Result<> McapWriter::put(std::string_view bytes) {
  if (torn_) {
    if (auto cut = sink_->cut_to(size_); !cut) return cut;
    torn_ = false;
  }
  if (auto written = sink_->write(bytes); !written) {
    torn_ = !sink_->cut_to(size_);
    return written;
  }
  size_ += bytes.size();
  data_crc_ = crc32_of(bytes, data_crc_);
  return {};
}

hal::Result<> McapWriter::begin(const std::string& profile, const std::string& library) {
  return put(std::string(kMagic) + encode_header(profile, library));
}

hal::Result<> McapWriter::attach(const Attachment& attachment) {
  const std::uint64_t at = size_;
  if (auto done = put(encode(attachment)); !done) return done;
  attachments_.push_back({at, size_ - at, attachment.log_time, attachment.create_time, attachment.data.size(),
                          attachment.name, attachment.content_type});
  ++statistics_.attachments;
  return {};
}

hal::Result<> McapWriter::add(const Metadata& metadata) {
  const std::uint64_t at = size_;
  if (auto done = put(encode(metadata)); !done) return done;
  metadata_.push_back({at, size_ - at, metadata.name});
  ++statistics_.metadata;
  return {};
}

hal::Result<> McapWriter::add(const Chunk& chunk, const std::map<std::uint16_t, Schema>& schemas,
                              const std::map<std::uint16_t, Channel>& channels) {
  // chunk and index in one piece: both are there or neither
  ChunkIndex index{chunk.start_time,     chunk.end_time,         size_, 0, {}, 0, chunk.compression,
                   chunk.records.size(), chunk.uncompressed_size};
  std::string bytes = encode(chunk);
  index.length = bytes.size();
  for (const auto& [channel, messages] : chunk.index) {
    index.message_index_offsets[channel] = size_ + bytes.size();
    bytes += encode_message_index(channel, messages);
  }
  index.message_index_length = bytes.size() - index.length;
  if (auto done = put(bytes); !done) return done;

  for (const auto& [id, messages] : chunk.index) {
    statistics_.per_channel[id] += messages.size();
    const auto channel = channels.find(id);
    if (channel == channels.end()) continue;
    channels_[id] = channel->second;
    const auto schema = schemas.find(channel->second.schema_id);
    if (schema != schemas.end()) schemas_[schema->first] = schema->second;
  }
  if (chunk.messages > 0) {
    Statistics& s = statistics_;
    s.start_time = s.messages == 0 ? chunk.start_time : std::min(s.start_time, chunk.start_time);
    s.end_time = std::max(s.end_time, chunk.end_time);
    s.messages += chunk.messages;
  }
  ++statistics_.chunks;
  chunks_.push_back(std::move(index));
  return {};
}

hal::Result<> McapWriter::finish() {
  statistics_.schemas = static_cast<std::uint16_t>(schemas_.size());
  statistics_.channels = static_cast<std::uint32_t>(channels_.size());
  const std::string end = encode_data_end(data_crc_);
  const std::uint64_t summary_start = size_ + end.size();

  std::string summary, offsets;
  const auto group = [&](Op op, const auto& items) {
    const std::uint64_t start = summary_start + summary.size();
    for (const auto& item : items) summary += encode(item);
    const std::uint64_t length = summary_start + summary.size() - start;
    if (length > 0) offsets += encode_summary_offset(op, start, length);
  };
  std::vector<Schema> schemas;
  for (const auto& [id, schema] : schemas_) schemas.push_back(schema);
  std::vector<Channel> channels;
  for (const auto& [id, channel] : channels_) channels.push_back(channel);
  group(Op::Schema, schemas);
  group(Op::Channel, channels);
  group(Op::Statistics, std::vector<Statistics>{statistics_});
  group(Op::ChunkIndex, chunks_);
  group(Op::AttachmentIndex, attachments_);
  group(Op::MetadataIndex, metadata_);

  const std::uint64_t offset_start = summary_start + summary.size();
  std::string tail = summary + offsets;
  ByteWriter w(tail);
  // the checksum covers the footer up to itself, so the record is put together by hand
  w.u8(static_cast<std::uint8_t>(Op::Footer)), w.u64(20), w.u64(summary_start), w.u64(offset_start);
  w.u32(crc32_of(tail));
  w.bytes(kMagic);
  if (auto done = put(end + tail); !done) return done;
  return sink_->flush();
}

}  // namespace colift::telemetry
