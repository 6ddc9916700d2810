#pragma once

#include <cstdint>
#include <filesystem>
#include <span>

#include "hal/types/result.hpp"

namespace colift::perception {

/// Writes a 16-bit grey PNG, values as they are. Errors: BadInput with the path.
[[nodiscard]] hal::Result<> write_grey_png(const std::filesystem::path& file, int width, int height,
                                           std::span<const std::uint16_t> values);

}  // namespace colift::perception
