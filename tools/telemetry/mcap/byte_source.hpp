#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>

#include "hal/types/result.hpp"

namespace colift::telemetry {

/// Where the bytes of a recording come from.
class ByteSource {
 public:
  virtual ~ByteSource() = default;
  [[nodiscard]] virtual std::uint64_t size() const = 0;
  /// Bytes from `offset` on, at most `count`, fewer where the source ends or cannot be read.
  [[nodiscard]] virtual std::string read(std::uint64_t offset, std::uint64_t count) const = 0;
};

/// Errors: BadInput (missing, a directory, unreadable).
[[nodiscard]] hal::Result<std::unique_ptr<ByteSource>> open_file(const std::filesystem::path& file);
[[nodiscard]] std::unique_ptr<ByteSource> source_of(std::string bytes);

}  // namespace colift::telemetry
