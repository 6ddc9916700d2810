#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace colift::telemetry {

// The records of an MCAP file (https://mcap.dev/spec, version 0): each is an opcode (8 bits), a length (64
// bits) and its content, all numbers little endian. Times are nanoseconds on the recording's own clock.

inline constexpr std::string_view kMagic{"\x89MCAP0\r\n", 8};
inline constexpr std::size_t kRecordHead = 9;  ///< Opcode and length.

enum class Op : std::uint8_t {
  Header = 0x01,
  Footer = 0x02,
  Schema = 0x03,
  Channel = 0x04,
  Message = 0x05,
  Chunk = 0x06,
  MessageIndex = 0x07,
  ChunkIndex = 0x08,
  Attachment = 0x09,
  AttachmentIndex = 0x0A,
  Statistics = 0x0B,
  Metadata = 0x0C,
  MetadataIndex = 0x0D,
  SummaryOffset = 0x0E,
  DataEnd = 0x0F,
};

/// What the messages of a channel look like.
struct Schema {
  std::uint16_t id = 0;
  std::string name, encoding, data;
};

/// A topic and how its messages are encoded.
struct Channel {
  std::uint16_t id = 0, schema_id = 0;
  std::string topic, message_encoding;
  std::map<std::string, std::string> metadata;
};

/// A message; its bytes belong to whoever handed it out.
struct Message {
  std::uint16_t channel_id = 0;
  std::uint32_t sequence = 0;
  std::uint64_t log_time = 0, publish_time = 0;
  std::string_view data;
};

/// Where the messages of one channel lie in a chunk: time and offset in its uncompressed bytes.
using MessageIndex = std::vector<std::pair<std::uint64_t, std::uint64_t>>;

/// A closed chunk, ready to be written anywhere.
struct Chunk {
  std::uint64_t start_time = 0, end_time = 0;
  std::uint64_t uncompressed_size = 0;
  std::uint32_t uncompressed_crc = 0;
  std::string compression, records;
  std::map<std::uint16_t, MessageIndex> index;
  std::uint64_t messages = 0;
};

/// Where a chunk lies (bytes from the start of the file), and what it holds.
struct ChunkIndex {
  std::uint64_t start_time = 0, end_time = 0, offset = 0, length = 0;
  std::map<std::uint16_t, std::uint64_t> message_index_offsets;
  std::uint64_t message_index_length = 0;
  std::string compression;
  std::uint64_t compressed_size = 0, uncompressed_size = 0;
};

/// A file inside the recording.
struct Attachment {
  std::uint64_t log_time = 0, create_time = 0;
  std::string name, content_type, data;
};

/// Where an attachment lies (bytes from the start of the file).
struct AttachmentIndex {
  std::uint64_t offset = 0, length = 0, log_time = 0, create_time = 0, data_size = 0;
  std::string name, content_type;
};

/// Names and texts about the recording.
struct Metadata {
  std::string name;
  std::map<std::string, std::string> entries;
};

/// Where metadata lie (bytes from the start of the file).
struct MetadataIndex {
  std::uint64_t offset = 0, length = 0;
  std::string name;
};

/// How much the recording holds.
struct Statistics {
  std::uint64_t messages = 0;
  std::uint16_t schemas = 0;
  std::uint32_t channels = 0, attachments = 0, metadata = 0, chunks = 0;
  std::uint64_t start_time = 0, end_time = 0;
  std::map<std::uint16_t, std::uint64_t> per_channel;
};

}  // namespace colift::telemetry
