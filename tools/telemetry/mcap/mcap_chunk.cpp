#include "tools/telemetry/mcap/mcap_chunk.hpp"

#include <zstd.h>

#include <algorithm>
#include <utility>

#include "tools/telemetry/mcap/mcap_encode.hpp"

namespace colift::telemetry {

struct ChunkBuilder::Zstd {
  ZSTD_CCtx* context = ZSTD_createCCtx();
  ~Zstd() { ZSTD_freeCCtx(context); }
};

ChunkBuilder::ChunkBuilder(int level) : zstd_(std::make_unique<Zstd>()), level_(level) {}
ChunkBuilder::~ChunkBuilder() = default;
ChunkBuilder::ChunkBuilder(ChunkBuilder&&) noexcept = default;
ChunkBuilder& ChunkBuilder::operator=(ChunkBuilder&&) noexcept = default;

void ChunkBuilder::add(const Schema* schema, const Channel& channel, const Message& message) {
  if (schema && !std::exchange(schemas_[schema->id], true)) records_ += encode(*schema);
  if (!std::exchange(channels_[channel.id], true)) records_ += encode(channel);
  chunk_.index[message.channel_id].emplace_back(message.log_time, records_.size());
  records_ += encode(message);
  chunk_.start_time = messages_ == 0 ? message.log_time : std::min(chunk_.start_time, message.log_time);
  chunk_.end_time = std::max(chunk_.end_time, message.log_time);
  ++messages_;
}

Chunk ChunkBuilder::close() {
  Chunk out = std::exchange(chunk_, {});
  out.messages = std::exchange(messages_, 0);
  out.uncompressed_size = records_.size();
  out.uncompressed_crc = crc32_of(records_);
  for (auto& [channel, index] : out.index) std::stable_sort(index.begin(), index.end());
  schemas_.clear();
  channels_.clear();
  std::string raw = std::exchange(records_, {});
  if (level_ > 0 && zstd_->context) {
    out.records.resize(ZSTD_compressBound(raw.size()));
    const std::size_t size = ZSTD_compressCCtx(zstd_->context, out.records.data(), out.records.size(),
                                               raw.data(), raw.size(), level_);
    if (!ZSTD_isError(size)) {
      out.records.resize(size);
      out.records.shrink_to_fit();
      out.compression = "zstd";
      return out;
    }
  }
  // without memory for a compressor the messages are still worth having
  out.records = std::move(raw);
  return out;
}

}  // namespace colift::telemetry
