#pragma once

#include <memory>

#include "perception/map/world_map.hpp"

namespace colift::perception {

/// The free and occupied cells of a grid as a pruned octree at OctoMap's clamping values. Only nodes that
/// stay are ever made: blocks of one state are found bottom up first. The grid's corners have to be whole
/// multiples of its cells.
[[nodiscard]] std::unique_ptr<octomap::OcTree> make_tree(const CellGrid& grid);

}  // namespace colift::perception
