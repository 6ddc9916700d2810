#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "tools/telemetry/mcap/mcap_records.hpp"

namespace colift::telemetry {

/// Collects messages and closes them into compressed chunks. A chunk carries the schemas and channels of its
/// own messages, so that it can be read alone: after a cut, or when the chunks before it were thrown away.
class ChunkBuilder {
 public:
  /// `level` is zstd's, 1 to 19; 0 leaves the chunks uncompressed.
  explicit ChunkBuilder(int level = 3);
  ~ChunkBuilder();
  ChunkBuilder(ChunkBuilder&&) noexcept;
  ChunkBuilder& operator=(ChunkBuilder&&) noexcept;

  /// `schema` may be null: a channel without one.
  void add(const Schema* schema, const Channel& channel, const Message& message);
  [[nodiscard]] bool empty() const { return messages_ == 0; }
  [[nodiscard]] std::size_t size() const { return records_.size(); }  ///< Uncompressed bytes.
  [[nodiscard]] std::uint64_t start_time() const { return chunk_.start_time; }
  /// What was collected; the builder is empty again.
  [[nodiscard]] Chunk close();

 private:
  struct Zstd;
  std::unique_ptr<Zstd> zstd_;
  int level_;
  std::string records_;
  Chunk chunk_;
  std::uint64_t messages_ = 0;
  std::map<std::uint16_t, bool> schemas_, channels_;
};

}  // namespace colift::telemetry
