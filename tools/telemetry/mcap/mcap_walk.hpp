#pragma once

// Inside of McapReader: one walk over a file from front to back. Not for other folders.

#include <cstdint>
#include <optional>
#include <set>
#include <string>

#include "tools/telemetry/mcap/byte_source.hpp"
#include "tools/telemetry/mcap/mcap_decode.hpp"
#include "tools/telemetry/mcap/mcap_reader.hpp"

namespace colift::telemetry {

/// The most that a chunk may become when it is decompressed, or that a record of the file may hold.
#ifdef FUZZING_BUILD_MODE_UNSAFE_FOR_PRODUCTION
inline constexpr std::uint64_t kMostChunkBytes = 1u << 22;
#else
inline constexpr std::uint64_t kMostChunkBytes = 1u << 29;
#endif

/// What came of decompressing.
struct Unpacked {
  std::string bytes;
  std::string error;  ///< Empty: all of it, and the checksum is right.
};
/// `cut`: the records end too early, and what they give is to be taken.
[[nodiscard]] Unpacked unpack(const ChunkHead& head, std::string_view records, bool cut);

/// Goes through all records of a data section, keeps what it learns in `info`, hands out messages.
class McapWalk {
 public:
  /// `index`: of the file's summary, to leave out chunks without any of `topics`; may be null.
  McapWalk(const ByteSource& source, const McapInfo* index, std::set<std::string> topics);
  [[nodiscard]] std::optional<Message> next();
  [[nodiscard]] McapInfo& info() { return info_; }

 private:
  [[nodiscard]] bool step();
  [[nodiscard]] bool wanted(std::uint64_t chunk_offset) const;
  [[nodiscard]] bool wanted_channel(std::uint16_t id) const;
  void take_chunk(std::string_view content, bool cut);
  void take_record(Op op, std::string_view content);
  void count(const Message& message);
  void hurt(std::string what);

  const ByteSource& source_;
  const McapInfo* index_;
  std::set<std::string> topics_;
  McapInfo info_;
  std::uint64_t at_ = 0;
  bool end_ = false;
  std::string content_, chunk_;    ///< Of the last record; of the last chunk, decompressed.
  std::size_t in_chunk_ = 0;       ///< How much of it was given.
  std::optional<Message> single_;  ///< A message outside of chunks.
};

}  // namespace colift::telemetry
