#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "tools/telemetry/mcap/mcap_records.hpp"

namespace colift::telemetry {

// Records as bytes, with opcode and length.

[[nodiscard]] std::string record(Op op, std::string_view content);
[[nodiscard]] std::string encode_header(std::string_view profile, std::string_view library);
[[nodiscard]] std::string encode(const Schema& schema);
[[nodiscard]] std::string encode(const Channel& channel);
[[nodiscard]] std::string encode(const Message& message);
[[nodiscard]] std::string encode(const Chunk& chunk);
[[nodiscard]] std::string encode_message_index(std::uint16_t channel, const MessageIndex& index);
[[nodiscard]] std::string encode(const ChunkIndex& index);
[[nodiscard]] std::string encode(const Attachment& attachment);
[[nodiscard]] std::string encode(const AttachmentIndex& index);
[[nodiscard]] std::string encode(const Metadata& metadata);
[[nodiscard]] std::string encode(const MetadataIndex& index);
[[nodiscard]] std::string encode(const Statistics& statistics);
[[nodiscard]] std::string encode_summary_offset(Op group, std::uint64_t start, std::uint64_t length);
[[nodiscard]] std::string encode_data_end(std::uint32_t crc);

/// CRC-32 as in zip and PNG; `before` goes on from an earlier piece.
[[nodiscard]] std::uint32_t crc32_of(std::string_view bytes, std::uint32_t before = 0);

}  // namespace colift::telemetry
