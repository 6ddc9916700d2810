#include "perception/map/cell_tree.hpp"

#include <octomap/octomap.h>

#include <array>
#include <cmath>
#include <vector>

namespace colift::perception {
namespace {

constexpr int kDepth = 16;  // levels of an OctoMap tree
constexpr int kHalf = 1 << (kDepth - 1);

enum class Block : std::uint8_t { Unknown, Free, Occupied, Mixed };

/// Blocks of 2^level cells along each edge, of those that meet the grid.
struct Level {
  Eigen::Vector3i first, size;  // first block by key / 2^level
  std::vector<Block> blocks;

  [[nodiscard]] std::size_t index(const Eigen::Vector3i& at) const {
    const Eigen::Vector3i d = at - first;
    return static_cast<std::size_t>((static_cast<std::ptrdiff_t>(d.z()) * size.y() + d.y()) * size.x() +
                                    d.x());
  }
  [[nodiscard]] Block block(const Eigen::Vector3i& at) const {
    const Eigen::Vector3i d = at - first;
    if ((d.array() < 0).any() || (d.array() >= size.array()).any()) return Block::Unknown;
    return blocks[index(at)];
  }
};

Level cells_of(const CellGrid& grid) {
  Level level;
  for (int axis = 0; axis < 3; ++axis) {
    level.first[axis] = static_cast<int>(std::lround(grid.origin[axis] / grid.cell_m)) + kHalf;
  }
  level.size = {grid.nx, grid.ny, grid.nz};
  level.blocks.reserve(grid.cells.size());
  for (const CellState state : grid.cells) {
    Block block = Block::Unknown;
    if (state == CellState::Free) block = Block::Free;
    if (state == CellState::Occupied) block = Block::Occupied;
    level.blocks.push_back(block);
  }
  return level;
}

Level coarser(const Level& fine) {
  Level level;
  level.first = fine.first / 2;
  level.size = (fine.first + fine.size - Eigen::Vector3i::Ones()) / 2 - level.first + Eigen::Vector3i::Ones();
  // every block is asked for by its eight parts; a part beyond the grid is unknown
  std::vector<std::uint8_t> seen(static_cast<std::size_t>(level.size.prod()), 0);
  std::vector<std::uint8_t> parts(seen.size(), 0);
  Eigen::Vector3i at;
  std::size_t i = 0;
  for (int z = 0; z < fine.size.z(); ++z) {
    for (int y = 0; y < fine.size.y(); ++y) {
      at = fine.first + Eigen::Vector3i(0, y, z);
      const std::size_t row = level.index({level.first.x(), at.y() / 2, at.z() / 2});
      for (int x = 0; x < fine.size.x(); ++x, ++i) {
        const auto block = row + static_cast<std::size_t>((fine.first.x() + x) / 2 - level.first.x());
        seen[block] = static_cast<std::uint8_t>(seen[block] | (1u << static_cast<unsigned>(fine.blocks[i])));
        ++parts[block];
      }
    }
  }
  level.blocks.resize(seen.size());
  for (std::size_t b = 0; b < seen.size(); ++b) {
    unsigned kinds = seen[b];
    if (parts[b] < 8) kinds |= 1u;
    Block block = Block::Mixed;
    if (kinds == 1u) block = Block::Unknown;
    if (kinds == 2u) block = Block::Free;
    if (kinds == 4u) block = Block::Occupied;
    level.blocks[b] = block;
  }
  return level;
}

class Tree : public octomap::OcTree {
 public:
  explicit Tree(const CellGrid& grid) : octomap::OcTree(grid.cell_m) {
    levels_[0] = cells_of(grid);
    for (std::size_t l = 1; l < levels_.size(); ++l) levels_[l] = coarser(levels_[l - 1]);
    if (levels_[kDepth].block(Eigen::Vector3i::Zero()) == Block::Unknown) return;
    root = new octomap::OcTreeNode();
    ++tree_size;
    fill(root, kDepth, Eigen::Vector3i::Zero());
    size_changed = true;
    levels_ = {};
  }

 private:
  void fill(octomap::OcTreeNode* node, int level, const Eigen::Vector3i& at) {
    const Block block = levels_[static_cast<std::size_t>(level)].block(at);
    if (block != Block::Mixed) {
      node->setLogOdds(block == Block::Occupied ? clamping_thres_max : clamping_thres_min);
      return;
    }
    for (unsigned child = 0; child < 8; ++child) {
      const Eigen::Vector3i part =
          2 * at + Eigen::Vector3i(child & 1u ? 1 : 0, child & 2u ? 1 : 0, child & 4u ? 1 : 0);
      if (levels_[static_cast<std::size_t>(level - 1)].block(part) == Block::Unknown) continue;
      fill(createNodeChild(node, child), level - 1, part);
    }
    node->updateOccupancyChildren();
  }

  std::array<Level, kDepth + 1> levels_;
};

}  // namespace

std::unique_ptr<octomap::OcTree> make_tree(const CellGrid& grid) {
  return std::make_unique<Tree>(grid);
}

}  // namespace colift::perception
