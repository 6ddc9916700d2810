#pragma once

#include <cstdint>
#include <filesystem>
#include <span>

#include "hal/types/result.hpp"

namespace colift::picture {

/// Refuses a file that could not be written, before the work whose result it is to hold. A folder that is
/// missing is made, if the one above it is there: "out/lift.png" needs no mkdir, and a mistyped path makes
/// nothing. Errors: BadInput with the path and what is in the way.
[[nodiscard]] hal::Result<> prepare_output(const std::filesystem::path& file);

/// Writes a whole file or nothing: the bytes go to a file beside it that takes its place at the end. Devices
/// and pipes are written to directly. Errors: BadInput with the path and what is in the way.
[[nodiscard]] hal::Result<> write_file(const std::filesystem::path& file,
                                       std::span<const std::uint8_t> bytes);

}  // namespace colift::picture
