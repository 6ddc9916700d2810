#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "hal/types/result.hpp"
#include "tools/telemetry/mcap/byte_sink.hpp"
#include "tools/telemetry/mcap/mcap_records.hpp"

namespace colift::telemetry {

/// Writes one MCAP file from front to back: header, attachments, metadata and chunks in any order, at the
/// end the summary with its indexes. Whatever could not be written whole is cut off again, so that the file
/// is good at every moment and the next piece can be tried. One thread.
class McapWriter {
 public:
  explicit McapWriter(std::unique_ptr<ByteSink> sink);

  // Errors of all calls: the sink's; nothing of that piece is in the file then.
  [[nodiscard]] hal::Result<> begin(const std::string& profile, const std::string& library);
  [[nodiscard]] hal::Result<> attach(const Attachment& attachment);
  [[nodiscard]] hal::Result<> add(const Metadata& metadata);
  /// `schemas` and `channels` are those of the chunk's messages, once more, for the summary.
  [[nodiscard]] hal::Result<> add(const Chunk& chunk, const std::map<std::uint16_t, Schema>& schemas,
                                  const std::map<std::uint16_t, Channel>& channels);
  /// Summary and footer. Without it the file is one that was cut: readable, but not indexed.
  [[nodiscard]] hal::Result<> finish();

  [[nodiscard]] std::uint64_t size() const { return size_; }  ///< Bytes of the file, as far as it is good.
  [[nodiscard]] const Statistics& statistics() const { return statistics_; }

 private:
  [[nodiscard]] hal::Result<> put(std::string_view bytes);

  std::unique_ptr<ByteSink> sink_;
  bool torn_ = false;  ///< Something half written lies behind size_.
  std::uint64_t size_ = 0;
  std::uint32_t data_crc_ = 0;
  Statistics statistics_;
  std::map<std::uint16_t, Schema> schemas_;
  std::map<std::uint16_t, Channel> channels_;
  std::vector<ChunkIndex> chunks_;
  std::vector<AttachmentIndex> attachments_;
  std::vector<MetadataIndex> metadata_;
};

}  // namespace colift::telemetry
