#include "perception/object_grid.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace colift::perception {
namespace {

constexpr double kMostCells = 2e6;

}  // namespace

ObjectGrid::ObjectGrid(std::span<const Eigen::Vector3f> points, double cell_m, double reach_m)
    : reach_m_(reach_m) {
  Eigen::AlignedBox3f box;
  for (const auto& p : points) {
    if (p.allFinite()) box.extend(p);
  }
  if (box.isEmpty()) return;

  const auto reach = static_cast<float>(reach_m);
  box.min().array() -= reach;
  box.max().array() += reach;
  const Eigen::Vector3d extent = box.sizes().cast<double>();
  const double edge_m = std::max(cell_m, std::cbrt(extent.prod() / kMostCells));
  per_cell_ = static_cast<float>(1.0 / edge_m);
  origin_ = box.min();
  std::size_t cells = 1;
  for (int a = 0; a < 3; ++a) {
    const auto i = static_cast<std::size_t>(a);
    size_[i] = static_cast<int>(std::ceil(extent[a] / edge_m)) + 1;
    size_f_[i] = static_cast<float>(size_[i]);
    cells *= static_cast<std::size_t>(size_[i]);
  }

  nearest_.assign(cells, kNone);
  std::vector<float> weight;
  std::vector<std::uint32_t> occupied;
  for (const auto& p : points) {
    if (!p.allFinite()) continue;
    const Eigen::Vector3f at = (p - origin_) * per_cell_;
    const std::size_t c = cell(static_cast<int>(at.x()), static_cast<int>(at.y()), static_cast<int>(at.z()));
    std::int32_t& patch = nearest_[c];
    if (patch == kNone) {
      occupied.push_back(static_cast<std::uint32_t>(c));
      patch = static_cast<std::int32_t>(patches_.size());
      patches_.emplace_back(Eigen::Vector3f::Zero());
      weight.push_back(0.0F);
    }
    patches_[static_cast<std::size_t>(patch)] += p - origin_;
    weight[static_cast<std::size_t>(patch)] += 1.0F;
  }
  for (std::size_t i = 0; i < patches_.size(); ++i) patches_[i] = patches_[i] / weight[i] + origin_;
  spread_from_patches(std::move(occupied));
}

// A wave from the occupied cells outwards: each cell offers its patch to its six neighbours, which take it
// when it is nearer than what they have. Not an exact distance transform, but wrong only by a fraction of a
// cell. `first` holds the occupied cells; a cell at the grid's border has no neighbours to offer to, as the
// object is farther than the reach from there.
void ObjectGrid::spread_from_patches(std::vector<std::uint32_t> first) {
  const float per_cell = per_cell_;
  const float reach = static_cast<float>(reach_m_) * per_cell;
  const float reach_squared = reach * reach;
  std::vector<Eigen::Vector3f> in_cells(patches_.size());  // less half a cell: distances of cell centres
  for (std::size_t i = 0; i < patches_.size(); ++i)
    in_cells[i] = (patches_[i] - origin_) * per_cell - Eigen::Vector3f::Constant(0.5F);
  std::vector<float> squared(nearest_.size(), reach_squared);
  for (const std::uint32_t c : first) squared[c] = 0.0F;
  const auto row = static_cast<std::uint32_t>(size_[0]);
  const std::uint32_t layer = row * static_cast<std::uint32_t>(size_[1]);
  std::vector<std::uint32_t> next;
  while (!first.empty()) {
    next.clear();
    for (const std::uint32_t from : first) {
      const std::uint32_t z = from / layer, in_layer = from - z * layer, y = in_layer / row, x = in_layer - y * row;
      if (x == 0 || y == 0 || z == 0 || x + 1 >= row || y + 1 >= static_cast<std::uint32_t>(size_[1]) ||
          z + 1 >= static_cast<std::uint32_t>(size_[2]))
        continue;
      const std::int32_t patch = nearest_[from];
      const Eigen::Vector3f off = Eigen::Vector3f(static_cast<float>(x), static_cast<float>(y), static_cast<float>(z)) -
                                  in_cells[static_cast<std::size_t>(patch)];
      const float here = off.squaredNorm() + 1.0F;
      // (a +- 1)^2 = a^2 +- 2 a + 1
      const auto offer = [&](std::uint32_t to, float d) {
        if (d >= squared[to]) return;
        squared[to] = d;
        nearest_[to] = patch;
        next.push_back(to);
      };
      offer(from - 1, here - 2.0F * off.x());
      offer(from + 1, here + 2.0F * off.x());
      offer(from - row, here - 2.0F * off.y());
      offer(from + row, here + 2.0F * off.y());
      offer(from - layer, here - 2.0F * off.z());
      offer(from + layer, here + 2.0F * off.z());
    }
    first.swap(next);
  }
}

}  // namespace colift::perception
