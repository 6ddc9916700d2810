#include "perception/object_grid.hpp"

#include <algorithm>
#include <cmath>

namespace colift::perception {
namespace {

constexpr double kMostCells = 2e6;  // bounds memory (8 MB) and the time of a new reference

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
  spread_from_patches(occupied);
}

// A wave from the occupied cells outwards: each cell offers its patch to its six neighbours, which take it
// when it is nearer than what they have. Not an exact distance transform, but wrong only by a fraction of a
// cell. `first` holds the occupied cells; a cell at the grid's border has no neighbours to offer to, as the
// object is farther than the reach from there.
void ObjectGrid::spread_from_patches(const std::vector<std::uint32_t>& first) {
  const float per_cell = per_cell_;
  const float reach = static_cast<float>(reach_m_) * per_cell;
  const float reach_squared = reach * reach;
  std::vector<Eigen::Vector3f> in_cells(patches_.size());  // less half a cell: distances of cell centres
  for (std::size_t i = 0; i < patches_.size(); ++i)
    in_cells[i] = (patches_[i] - origin_) * per_cell - Eigen::Vector3f::Constant(0.5F);
  std::vector<float> squared(nearest_.size(), reach_squared);
  struct At {
    std::uint32_t cell;
    std::uint16_t x, y, z;
  };
  const auto row = static_cast<std::uint32_t>(size_[0]);
  const std::uint32_t layer = row * static_cast<std::uint32_t>(size_[1]);
  const auto last_x = static_cast<std::uint16_t>(size_[0] - 1),
             last_y = static_cast<std::uint16_t>(size_[1] - 1),
             last_z = static_cast<std::uint16_t>(size_[2] - 1);
  std::vector<At> wave, next;
  wave.reserve(4 * first.size());
  next.reserve(4 * first.size());
  for (const std::uint32_t c : first) {
    squared[c] = 0.0F;
    wave.push_back({c, static_cast<std::uint16_t>(c % row), static_cast<std::uint16_t>(c % layer / row),
                    static_cast<std::uint16_t>(c / layer)});
  }
  while (!wave.empty()) {
    next.clear();
    for (const At& at : wave) {
      if (at.x == 0 || at.y == 0 || at.z == 0 || at.x == last_x || at.y == last_y || at.z == last_z) continue;
      const std::int32_t patch = nearest_[at.cell];
      const Eigen::Vector3f off =
          Eigen::Vector3f(at.x, at.y, at.z) - in_cells[static_cast<std::size_t>(patch)];
      const float here = off.squaredNorm() + 1.0F;
      const auto offer = [&](std::uint32_t to, float d, int dx, int dy, int dz) {
        if (d >= squared[to]) return;
        squared[to] = d;
        nearest_[to] = patch;
        next.push_back({to, static_cast<std::uint16_t>(at.x + dx), static_cast<std::uint16_t>(at.y + dy),
                        static_cast<std::uint16_t>(at.z + dz)});
      };
      // (a +- 1)^2 = a^2 +- 2 a + 1
      offer(at.cell - 1, here - 2.0F * off.x(), -1, 0, 0);
      offer(at.cell + 1, here + 2.0F * off.x(), 1, 0, 0);
      offer(at.cell - row, here - 2.0F * off.y(), 0, -1, 0);
      offer(at.cell + row, here + 2.0F * off.y(), 0, 1, 0);
      offer(at.cell - layer, here - 2.0F * off.z(), 0, 0, -1);
      offer(at.cell + layer, here + 2.0F * off.z(), 0, 0, 1);
    }
    wave.swap(next);
  }
}

}  // namespace colift::perception
