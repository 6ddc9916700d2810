#pragma once

#include <cstdint>
#include <filesystem>
#include <span>

#include "hal/types/result.hpp"

namespace colift::picture {

/// Writes a whole file or nothing: the bytes go to a file beside it that takes its place at the end. Devices
/// and pipes are written to directly. Errors: BadInput with the path and what is in the way.
[[nodiscard]] hal::Result<> write_file(const std::filesystem::path& file,
                                       std::span<const std::uint8_t> bytes);

}  // namespace colift::picture
