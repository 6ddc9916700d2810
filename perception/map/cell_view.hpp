#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "perception/map/world_map.hpp"

namespace colift::perception {

/// What one frame says of a cell.
enum class CellView : std::uint8_t {
  Through,    ///< The rays through its middle go on beyond it.
  Hit,        ///< Measurements that count as scene end in it.
  Behind,     ///< The ray through its middle ends before it, or in it without a hit.
  OutOfView,  ///< Not in the image, or nothing measured there.
};

/// Looks at every cell of a grid (its `cells` are not used) through one frame; `view` gets one entry per
/// cell. Pixels in `not_scene` (ascending) end rays but hit nothing, those beyond `max_range_m` too.
void view_cells(const CellGrid& grid, const OrganisedCloud& cloud, std::span<const std::uint32_t> not_scene,
                double max_range_m, std::vector<CellView>& view, const CellViewConfig& config = {});

}  // namespace colift::perception
