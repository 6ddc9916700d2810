#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "tools/telemetry/mcap/mcap_records.hpp"

namespace colift::telemetry {

// Contents of records from bytes that nobody vouches for. Nothing: too short, or lengths that contradict
// each other. Fields that a later version of the format appends are left alone.

[[nodiscard]] std::optional<Schema> decode_schema(std::string_view content);
[[nodiscard]] std::optional<Channel> decode_channel(std::string_view content);
/// The data is a view into `content`.
[[nodiscard]] std::optional<Message> decode_message(std::string_view content);
[[nodiscard]] std::optional<ChunkIndex> decode_chunk_index(std::string_view content);
[[nodiscard]] std::optional<AttachmentIndex> decode_attachment_index(std::string_view content);
[[nodiscard]] std::optional<Statistics> decode_statistics(std::string_view content);
[[nodiscard]] std::optional<Metadata> decode_metadata(std::string_view content);
[[nodiscard]] std::optional<MetadataIndex> decode_metadata_index(std::string_view content);

struct FileHeader {
  std::string profile, library;
};
[[nodiscard]] std::optional<FileHeader> decode_header(std::string_view content);

/// An attachment; `crc_good` is false when its checksum is another one.
struct ReadAttachment {
  Attachment attachment;
  bool crc_good = true;
};
[[nodiscard]] std::optional<ReadAttachment> decode_attachment(std::string_view content);
/// The same without its data, from the first bytes of the record; `length` is the whole content's.
[[nodiscard]] std::optional<AttachmentIndex> decode_attachment_head(std::string_view first_bytes);

/// What stands before a chunk's records.
struct ChunkHead {
  std::uint64_t start_time = 0, end_time = 0, uncompressed_size = 0;
  std::uint32_t uncompressed_crc = 0;
  std::string compression;
  std::uint64_t records_size = 0;
  std::size_t bytes = 0;  ///< Of this head; the records begin behind it.
};
[[nodiscard]] std::optional<ChunkHead> decode_chunk_head(std::string_view content);

}  // namespace colift::telemetry
