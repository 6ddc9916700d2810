#include "perception/object_grid.hpp"

#include <algorithm>
#include <cmath>

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
  for (const auto& p : points) {
    if (!p.allFinite()) continue;
    const Eigen::Vector3f at = (p - origin_) * per_cell_;
    std::int32_t& patch =
        nearest_[cell(static_cast<int>(at.x()), static_cast<int>(at.y()), static_cast<int>(at.z()))];
    if (patch == kNone) {
      patch = static_cast<std::int32_t>(patches_.size());
      patches_.emplace_back(Eigen::Vector3f::Zero());
      weight.push_back(0.0F);
    }
    patches_[static_cast<std::size_t>(patch)] += p - origin_;
    weight[static_cast<std::size_t>(patch)] += 1.0F;
  }
  for (std::size_t i = 0; i < patches_.size(); ++i) patches_[i] = patches_[i] / weight[i] + origin_;
  spread_from_patches();
}

// A wave from the occupied cells outwards: each cell offers its patch to its six neighbours, which take it
// when it is nearer than what they have. Not an exact distance transform, but wrong only by a fraction of a
// cell.
void ObjectGrid::spread_from_patches() {
  const float cell_m = 1.0F / per_cell_;
  const auto reach_squared = static_cast<float>(reach_m_ * reach_m_);
  std::vector<float> squared(nearest_.size(), std::numeric_limits<float>::max());
  struct At {
    std::int16_t x, y, z;
  };
  std::vector<At> wave, next;
  for (int z = 0; z < size_[2]; ++z) {
    for (int y = 0; y < size_[1]; ++y) {
      for (int x = 0; x < size_[0]; ++x) {
        if (nearest_[cell(x, y, z)] == kNone) continue;
        squared[cell(x, y, z)] = 0.0F;
        wave.push_back(
            {static_cast<std::int16_t>(x), static_cast<std::int16_t>(y), static_cast<std::int16_t>(z)});
      }
    }
  }
  constexpr int kSteps[6][3] = {{-1, 0, 0}, {1, 0, 0}, {0, -1, 0}, {0, 1, 0}, {0, 0, -1}, {0, 0, 1}};
  while (!wave.empty()) {
    next.clear();
    for (const At& from : wave) {
      const std::int32_t patch = nearest_[cell(from.x, from.y, from.z)];
      const Eigen::Vector3f& p = patches_[static_cast<std::size_t>(patch)];
      for (const auto& step : kSteps) {
        const int x = from.x + step[0], y = from.y + step[1], z = from.z + step[2];
        if (x < 0 || y < 0 || z < 0 || x >= size_[0] || y >= size_[1] || z >= size_[2]) continue;
        const Eigen::Vector3f centre =
            origin_ + cell_m * Eigen::Vector3f(static_cast<float>(x) + 0.5F, static_cast<float>(y) + 0.5F,
                                               static_cast<float>(z) + 0.5F);
        const float d = (centre - p).squaredNorm();
        const std::size_t to = cell(x, y, z);
        if (d >= squared[to] || d > reach_squared) continue;
        squared[to] = d;
        nearest_[to] = patch;
        next.push_back(
            {static_cast<std::int16_t>(x), static_cast<std::int16_t>(y), static_cast<std::int16_t>(z)});
      }
    }
    wave.swap(next);
  }
}

}  // namespace colift::perception
