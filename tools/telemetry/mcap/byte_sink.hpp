#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string_view>

#include "hal/types/result.hpp"

namespace colift::telemetry {

/// Where the bytes of a recording go. Only grows at its end, and can be cut back to an earlier length.
class ByteSink {
 public:
  virtual ~ByteSink() = default;
  /// All of it or an error; after an error some bytes may have been written: cut_to().
  [[nodiscard]] virtual hal::Result<> write(std::string_view bytes) = 0;
  [[nodiscard]] virtual hal::Result<> cut_to(std::uint64_t length) = 0;
  /// Makes sure that everything is on the disk.
  [[nodiscard]] virtual hal::Result<> flush() = 0;
};

/// A new file; one that is there is replaced. Errors of all calls: BadInput with the path and the system's
/// words (no space, no such folder).
[[nodiscard]] hal::Result<std::unique_ptr<ByteSink>> create_file(const std::filesystem::path& file);

}  // namespace colift::telemetry
