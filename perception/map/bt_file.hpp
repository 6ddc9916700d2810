#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "hal/types/result.hpp"
#include "perception/map/world_map.hpp"

namespace colift::perception {

/// Reads an OctoMap .bt file into the cells of a grid that is laid out already (aligned to the file's cells:
/// corners at whole multiples of cell_m). Cells that the file does not know, or that lie outside, stay as
/// they are. OctoMap's own reader prints to stderr, recurses as deep as a file wishes and believes its
/// counters; this one does none of it. Errors: BadInput.
[[nodiscard]] hal::Result<> read_bt(const std::filesystem::path& file, CellGrid& grid);

}  // namespace colift::perception
