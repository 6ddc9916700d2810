#include "tools/telemetry/mcap/mcap_walk.hpp"

#include <fmt/format.h>
#include <zstd.h>

#include <algorithm>

#include "tools/telemetry/mcap/byte_io.hpp"
#include "tools/telemetry/mcap/mcap_encode.hpp"

namespace colift::telemetry {
namespace {

constexpr std::uint64_t kAttachmentHead = 4096;  // names longer than this are nobody's

struct Stream {
  ZSTD_DStream* stream = ZSTD_createDStream();
  ~Stream() { ZSTD_freeDStream(stream); }
};

/// Decompresses as far as it goes; memory grows with what is really there, whatever the head says.
std::string unzip(std::string_view records, std::uint64_t most, bool& whole) {
  Stream zstd;
  std::string out;
  whole = false;
  if (!zstd.stream) return out;
  ZSTD_inBuffer in{records.data(), records.size(), 0};
  std::string block(ZSTD_DStreamOutSize(), '\0');
  for (;;) {
    ZSTD_outBuffer to{block.data(), block.size(), 0};
    const std::size_t left = ZSTD_decompressStream(zstd.stream, &to, &in);
    out.append(block.data(), to.pos);
    if (ZSTD_isError(left) || out.size() > most) return out;
    if (left == 0 && in.pos == in.size) break;
    if (to.pos == 0 && in.pos == in.size) return out;  // it wants more than there is
  }
  whole = true;
  return out;
}

}  // namespace

Unpacked unpack(const ChunkHead& head, std::string_view records, bool cut) {
  Unpacked out;
  if (head.uncompressed_size > kMostChunkBytes) {
    out.error = fmt::format("claims {} bytes (limit {})", head.uncompressed_size, kMostChunkBytes);
    return out;
  }
  bool whole = true;
  if (head.compression == "zstd")
    out.bytes = unzip(records, head.uncompressed_size, whole);
  else if (head.compression.empty())
    out.bytes = std::string(records);
  else
    out.error =
        fmt::format("is compressed by \"{}\"; expected zstd or nothing", head.compression.substr(0, 40));
  if (!out.error.empty() || cut) return out;
  if (!whole || out.bytes.size() != head.uncompressed_size)
    out.error = fmt::format("gives {} of {} bytes", out.bytes.size(), head.uncompressed_size);
  else if (head.uncompressed_crc != 0 && crc32_of(out.bytes) != head.uncompressed_crc)
    out.error = "has a wrong checksum";
  if (!out.error.empty()) out.bytes.clear();
  return out;
}

McapWalk::McapWalk(const ByteSource& source, const McapInfo* index, std::set<std::string> topics)
    : source_(source), index_(index), topics_(std::move(topics)), at_(kMagic.size()) {
  info_.size = source.size();
  info_.readable = at_;
}

void McapWalk::hurt(std::string what) {
  // a file of rubbish gives no endless list
  if (info_.damage.size() < 20) info_.damage.push_back(std::move(what));
}

bool McapWalk::wanted(std::uint64_t chunk_offset) const {
  if (!index_ || topics_.empty()) return true;
  const auto chunk = std::lower_bound(index_->chunks.begin(), index_->chunks.end(), chunk_offset,
                                      [](const ChunkIndex& c, std::uint64_t at) { return c.offset < at; });
  if (chunk == index_->chunks.end() || chunk->offset != chunk_offset || chunk->message_index_offsets.empty())
    return true;
  return std::any_of(chunk->message_index_offsets.begin(), chunk->message_index_offsets.end(),
                     [&](const auto& entry) {
                       const auto channel = index_->channels.find(entry.first);
                       return channel == index_->channels.end() || topics_.count(channel->second.topic);
                     });
}

bool McapWalk::wanted_channel(std::uint16_t id) const {
  if (topics_.empty()) return true;
  const auto channel = info_.channels.find(id);
  return channel != info_.channels.end() && topics_.count(channel->second.topic);
}

void McapWalk::count(const Message& m) {
  Statistics& s = info_.statistics;
  s.start_time = s.messages == 0 ? m.log_time : std::min(s.start_time, m.log_time);
  s.end_time = std::max(s.end_time, m.log_time);
  ++s.messages;
  ++s.per_channel[m.channel_id];
}

void McapWalk::take_record(Op op, std::string_view content) {
  if (op == Op::Schema) {
    if (auto schema = decode_schema(content)) info_.schemas.emplace(schema->id, std::move(*schema));
  } else if (op == Op::Channel) {
    if (auto channel = decode_channel(content)) info_.channels.emplace(channel->id, std::move(*channel));
  } else if (op == Op::Header) {
    if (auto header = decode_header(content))
      info_.profile = header->profile, info_.library = header->library;
  } else if (op == Op::Message) {
    if ((single_ = decode_message(content))) count(*single_);
  }
}

void McapWalk::take_chunk(std::string_view content, bool cut) {
  const auto head = decode_chunk_head(content);
  if (!head) {
    hurt(fmt::format("the chunk at byte {} has no whole head", at_));
    return;
  }
  std::string_view records = content.substr(head->bytes);
  if (!cut && head->records_size != records.size()) {
    hurt(fmt::format("the chunk at byte {} says {} bytes and has {}", at_, head->records_size,
                     records.size()));
    if (head->records_size > records.size()) return;
    records = records.substr(0, static_cast<std::size_t>(head->records_size));
  }
  Unpacked unpacked = unpack(*head, records, cut);
  if (!unpacked.error.empty())
    hurt(fmt::format("the chunk at byte {} {}; it is left out", at_, unpacked.error));
  chunk_ = std::move(unpacked.bytes);
  in_chunk_ = 0;
  info_.chunks.push_back({head->start_time,
                          head->end_time,
                          at_,
                          kRecordHead + content.size(),
                          {},
                          0,
                          head->compression,
                          records.size(),
                          head->uncompressed_size});
  ++info_.statistics.chunks;
}

bool McapWalk::step() {
  const std::string head = source_.read(at_, kRecordHead);
  if (head.size() < kRecordHead) {
    hurt(fmt::format("the file ends at byte {}, within a record", info_.size));
    return false;
  }
  ByteReader r(head);
  const Op op{r.u8()};
  const std::uint64_t length = r.u64(), left = info_.size - at_ - kRecordHead;
  const bool cut = length > left;
  if (cut) hurt(fmt::format("the file ends at byte {}, within a record that begins at {}", info_.size, at_));
  if (op == Op::DataEnd || op == Op::Footer) {
    if (!cut) info_.readable = at_ + kRecordHead + length;
    return false;
  }
  const bool skip = op == Op::Chunk && !wanted(at_);
  const bool known = op == Op::Header || op == Op::Schema || op == Op::Channel || op == Op::Message ||
                     op == Op::Chunk || op == Op::Metadata;
  if (op == Op::Attachment) {
    auto index = decode_attachment_head(source_.read(at_ + kRecordHead, std::min(length, kAttachmentHead)));
    if (index && !cut) {
      index->offset = at_;
      index->length = kRecordHead + length;
      info_.attachments.push_back(std::move(*index));
      ++info_.statistics.attachments;
    }
  } else if (known && !skip) {
    if (std::min(length, left) > kMostChunkBytes) {
      hurt(fmt::format("the record at byte {} has {} bytes (limit {}); it is left out", at_, length,
                       kMostChunkBytes));
    } else if (op == Op::Chunk) {
      content_ = source_.read(at_ + kRecordHead, std::min(length, left));
      take_chunk(content_, cut);
    } else if (!cut) {
      content_ = source_.read(at_ + kRecordHead, length);
      if (op == Op::Metadata) {
        if (const auto metadata = decode_metadata(content_)) {
          info_.metadata.push_back({at_, kRecordHead + length, metadata->name});
          ++info_.statistics.metadata;
        }
      } else {
        take_record(op, content_);
      }
    }
  }
  if (cut) {
    end_ = true;  // what the cut chunk gave is still handed out
    return true;
  }
  at_ += kRecordHead + length;
  info_.readable = at_;
  return true;
}

std::optional<Message> McapWalk::next() {
  for (;;) {
    while (in_chunk_ < chunk_.size()) {
      ByteReader r(std::string_view(chunk_).substr(in_chunk_));
      const Op op{r.u8()};
      const std::string_view content = r.bytes(r.u64());
      if (!r.ok()) {
        if (!end_) hurt(fmt::format("the chunk before byte {} holds a record that does not end", at_));
        in_chunk_ = chunk_.size();
        break;
      }
      in_chunk_ += r.at();
      if (op != Op::Message) {
        take_record(op, content);
        continue;
      }
      const auto message = decode_message(content);
      if (!message) continue;
      count(*message);
      if (wanted_channel(message->channel_id)) return message;
    }
    if (single_) {
      const Message message = *single_;
      single_.reset();
      if (wanted_channel(message.channel_id)) return message;
    }
    if (end_) return std::nullopt;
    if (!step()) end_ = true;
  }
}

}  // namespace colift::telemetry
