#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "hal/types/result.hpp"
#include "tools/telemetry/mcap/byte_source.hpp"
#include "tools/telemetry/mcap/mcap_records.hpp"

namespace colift::telemetry {

/// What is known of a recording without its messages.
struct McapInfo {
  std::string profile, library;
  std::map<std::uint16_t, Schema> schemas;
  std::map<std::uint16_t, Channel> channels;
  std::vector<ChunkIndex> chunks;  ///< Their message indexes only where the file has a summary.
  std::vector<AttachmentIndex> attachments;
  std::vector<MetadataIndex> metadata;
  Statistics statistics;  ///< Counted where the file has none.
  bool complete = false;  ///< Has its summary and its end.
  std::uint64_t size = 0;
  std::uint64_t readable = 0;       ///< Bytes up to which it can be read; all of them when nothing is wrong.
  std::vector<std::string> damage;  ///< What is wrong, one sentence each; empty when nothing is.

  [[nodiscard]] const Channel* channel(const std::string& topic) const;
};

/// Reads MCAP files that nobody vouches for: whole ones by their summary, all others from the front, up to
/// where they are cut or damaged. A damaged chunk in the middle is left out and counted; of a chunk that was
/// cut the messages are given that can still be decompressed. Chunks are zstd or uncompressed.
class McapReader {
 public:
  /// Errors: BadInput (no MCAP file at all: too short, or another magic).
  [[nodiscard]] static hal::Result<McapReader> open(std::unique_ptr<ByteSource> source,
                                                    const std::string& name);
  ~McapReader();
  McapReader(McapReader&&) noexcept;
  McapReader& operator=(McapReader&&) noexcept;

  [[nodiscard]] const McapInfo& info() const { return info_; }
  /// The same, read from the front even when there is a summary: finds damage that the summary hides.
  [[nodiscard]] McapInfo scan() const;

  /// Errors: BadInput (not readable, or its checksum is wrong), NotFound.
  [[nodiscard]] hal::Result<Attachment> attachment(const std::string& name) const;
  [[nodiscard]] hal::Result<Metadata> metadata(const std::string& name) const;

  /// Gives the messages in the order of the file, one after the other. The reader has to outlive it.
  class Cursor {
   public:
    ~Cursor();
    Cursor(Cursor&&) noexcept;
    /// The next message, valid until the next call; nothing at the end, or where reading ends.
    [[nodiscard]] std::optional<Message> next();

   private:
    friend class McapReader;
    struct Walk;
    explicit Cursor(std::unique_ptr<Walk> ramp);
    std::unique_ptr<Walk> walk_;
  };
  /// All messages, or those of some topics.
  [[nodiscard]] Cursor messages(const std::set<std::string>& topics = {}) const;

 private:
  McapReader(std::unique_ptr<ByteSource> source, std::string name);
  [[nodiscard]] bool read_summary();

  std::unique_ptr<ByteSource> source_;
  std::string name_;
  McapInfo info_;
};

}  // namespace colift::telemetry
