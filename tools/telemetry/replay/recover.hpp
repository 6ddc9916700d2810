#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "hal/types/result.hpp"
#include "tools/telemetry/mcap/mcap_reader.hpp"

namespace colift::telemetry {

struct Recovered {
  std::uint64_t messages = 0, attachments = 0, metadata = 0, bytes = 0;
  std::vector<std::string> damage;  ///< What was wrong with the file that was read.
};

/// Writes everything that can still be read into a new file that is whole and indexed. Errors: BadInput (the
/// new file cannot be written).
[[nodiscard]] hal::Result<Recovered> recover(const McapReader& file, const std::filesystem::path& to);

}  // namespace colift::telemetry
