#include "tools/telemetry/mcap/mcap_reader.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "tools/telemetry/mcap/byte_io.hpp"
#include "tools/telemetry/mcap/mcap_decode.hpp"
#include "tools/telemetry/mcap/mcap_encode.hpp"
#include "tools/telemetry/mcap/mcap_walk.hpp"

namespace colift::telemetry {
namespace {

constexpr std::uint64_t kFooter = kRecordHead + 20;

}  // namespace

struct McapReader::Cursor::Walk : McapWalk {
  using McapWalk::McapWalk;
};

McapReader::Cursor::Cursor(std::unique_ptr<Walk> ramp) : walk_(std::move(ramp)) {}
McapReader::Cursor::~Cursor() = default;
McapReader::Cursor::Cursor(Cursor&&) noexcept = default;
std::optional<Message> McapReader::Cursor::next() {
  return walk_->next();
}

const Channel* McapInfo::channel(const std::string& topic) const {
  for (const auto& [id, channel] : channels)
    if (channel.topic == topic) return &channel;
  return nullptr;
}

McapReader::McapReader(std::unique_ptr<ByteSource> source, std::string name)
    : source_(std::move(source)), name_(std::move(name)) {}
McapReader::~McapReader() = default;
McapReader::McapReader(McapReader&&) noexcept = default;
McapReader& McapReader::operator=(McapReader&&) noexcept = default;

hal::Result<McapReader> McapReader::open(std::unique_ptr<ByteSource> source, const std::string& name) {
  const std::string magic = source->read(0, kMagic.size());
  if (magic.size() < kMagic.size())
    return hal::failure(hal::ErrorCode::BadInput, name,
                        fmt::format("has {} bytes; expected an MCAP file", source->size()));
  if (magic != kMagic)
    return hal::failure(hal::ErrorCode::BadInput, name,
                        "does not begin as an MCAP file of version 0 does (89 4D 43 41 50 30 0D 0A)");
  McapReader reader(std::move(source), name);
  if (!reader.read_summary()) reader.info_ = reader.scan();
  return reader;
}

McapInfo McapReader::scan() const {
  McapWalk ramp(*source_, nullptr, {});
  while (ramp.next()) {
  }
  McapInfo info = std::move(ramp.info());
  info.statistics.schemas = static_cast<std::uint16_t>(info.schemas.size());
  info.statistics.channels = static_cast<std::uint32_t>(info.channels.size());
  info.complete = info_.complete;
  if (info_.complete) info.readable = info.size;
  if (!info_.complete && info.damage.empty())
    info.damage.push_back("the file has no summary at its end: whoever wrote it was interrupted");
  return info;
}

bool McapReader::read_summary() {
  const std::uint64_t size = source_->size();
  if (size < 2 * kMagic.size() + kFooter) return false;
  const std::string tail = source_->read(size - kMagic.size() - kFooter, kFooter + kMagic.size());
  ByteReader footer(tail);
  if (Op{footer.u8()} != Op::Footer || footer.u64() != 20) return false;
  const std::uint64_t start = footer.u64(), offsets = footer.u64();
  const std::uint32_t crc = footer.u32();
  if (footer.bytes(kMagic.size()) != kMagic) return false;
  const std::uint64_t end = size - kMagic.size() - kFooter;
  if (start < kMagic.size() || start > end || end - start > kMostChunkBytes) return false;
  if (offsets != 0 && (offsets < start || offsets > end)) return false;

  const std::string summary = source_->read(start, end - start + kFooter - 4);
  if (summary.size() != end - start + kFooter - 4) return false;
  if (crc != 0 && crc32_of(summary) != crc) return false;

  McapInfo info;
  bool counted = false;
  ByteReader r(std::string_view(summary).substr(0, static_cast<std::size_t>(end - start)));
  while (r.left() > 0) {
    const Op op{r.u8()};
    const std::string_view content = r.bytes(r.u64());
    if (!r.ok()) return false;
    const auto keep = [](auto found, auto& list) {
      if (found) list.push_back(std::move(*found));
      return found.has_value();
    };
    if (op == Op::Schema) {
      if (auto schema = decode_schema(content)) info.schemas.emplace(schema->id, std::move(*schema));
    } else if (op == Op::Channel) {
      if (auto channel = decode_channel(content)) info.channels.emplace(channel->id, std::move(*channel));
    } else if (op == Op::ChunkIndex) {
      if (!keep(decode_chunk_index(content), info.chunks)) return false;
    } else if (op == Op::AttachmentIndex) {
      if (!keep(decode_attachment_index(content), info.attachments)) return false;
    } else if (op == Op::MetadataIndex) {
      if (!keep(decode_metadata_index(content), info.metadata)) return false;
    } else if (op == Op::Statistics) {
      auto statistics = decode_statistics(content);
      if (!statistics) return false;
      info.statistics = std::move(*statistics);
      counted = true;
    }
  }
  if (!counted) return false;
  std::sort(info.chunks.begin(), info.chunks.end(),
            [](const ChunkIndex& a, const ChunkIndex& b) { return a.offset < b.offset; });
  // the first record is the header
  const std::string head = source_->read(kMagic.size(), kRecordHead);
  ByteReader first(head);
  if (Op{first.u8()} != Op::Header) return false;
  const std::uint64_t length = first.u64();
  if (length > size) return false;
  const auto header =
      decode_header(source_->read(kMagic.size() + kRecordHead, std::min<std::uint64_t>(length, 1u << 16)));
  if (!header) return false;
  info.profile = header->profile;
  info.library = header->library;
  info.complete = true;
  info.size = info.readable = size;
  info_ = std::move(info);
  return true;
}

hal::Result<Attachment> McapReader::attachment(const std::string& name) const {
  for (const AttachmentIndex& index : info_.attachments) {
    if (index.name != name) continue;
    const auto bad = [&](const char* why) {
      return hal::failure(hal::ErrorCode::BadInput, name_, fmt::format("its attachment {} {}", name, why));
    };
    if (index.length < kRecordHead || index.length - kRecordHead > kMostChunkBytes)
      return bad("has an impossible size");
    const std::string bytes = source_->read(index.offset, index.length);
    ByteReader r(bytes);
    if (Op{r.u8()} != Op::Attachment) return bad("is not where the index says");
    auto found = decode_attachment(r.bytes(r.u64()));
    if (!found) return bad("is damaged");
    if (!found->crc_good) return bad("has a wrong checksum");
    return std::move(found->attachment);
  }
  return hal::failure(hal::ErrorCode::NotFound, name_, fmt::format("has no attachment {}", name));
}

hal::Result<Metadata> McapReader::metadata(const std::string& name) const {
  const MetadataIndex* last = nullptr;  // a later one replaces an earlier one
  for (const MetadataIndex& index : info_.metadata)
    if (index.name == name) last = &index;
  if (!last) return hal::failure(hal::ErrorCode::NotFound, name_, fmt::format("has no metadata {}", name));
  const std::string bytes = source_->read(last->offset, std::min(last->length, kMostChunkBytes));
  ByteReader r(bytes);
  if (Op{r.u8()} == Op::Metadata)
    if (auto found = decode_metadata(r.bytes(r.u64()))) return std::move(*found);
  return hal::failure(hal::ErrorCode::BadInput, name_, fmt::format("its metadata {} is damaged", name));
}

McapReader::Cursor McapReader::messages(const std::set<std::string>& topics) const {
  return Cursor(std::make_unique<Cursor::Walk>(*source_, info_.complete ? &info_ : nullptr, topics));
}

}  // namespace colift::telemetry
