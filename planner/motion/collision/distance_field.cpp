#include "planner/motion/collision/distance_field.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "planner/motion/collision/near_points.hpp"
#include "planner/motion/collision/squared_distances.hpp"

namespace colift::planner {
namespace {

/// Rounding of single precision in p and in the interpolation (cells^2, at coordinates of some metres).
constexpr float kRounding = 1e-3f;

}  // namespace

DistanceField::DistanceField(const perception::CellGrid& grid, const std::vector<std::uint8_t>& is_obstacle,
                             double max_m)
    : origin_(grid.origin.cast<float>()),
      cell_m_(static_cast<float>(grid.cell_m)),
      per_m_(static_cast<float>(1.0 / grid.cell_m)) {
  reach_ = std::clamp(static_cast<int>(std::ceil(max_m / grid.cell_m - 1e-9)), 1, kMaxReach_cells);
  max_m_ = static_cast<float>(reach_) * cell_m_;
  nx_ = grid.nx + 1;
  ny_ = grid.ny + 1;
  nz_ = grid.nz + 1;
  if (std::memchr(is_obstacle.data(), 1, is_obstacle.size()) == nullptr) return;  // 0 and 1 alone
  squared_ = std::make_shared<const std::vector<std::int16_t>>(
      squared_distances({grid.nx, grid.ny, grid.nz}, is_obstacle, reach_));
}

void DistanceField::add(const BoxDistances& obstacles) {
  if (obstacles.squared.empty()) return;
  const std::size_t corners =
      static_cast<std::size_t>(nx_) * static_cast<std::size_t>(ny_) * static_cast<std::size_t>(nz_);
  const auto all = empty() ? std::make_shared<std::vector<std::int16_t>>(
                                 corners, static_cast<std::int16_t>(reach_ * reach_))
                           : std::make_shared<std::vector<std::int16_t>>(*squared_);
  // the distance to all is the smaller of the distances to the old and to the new
  const Eigen::Vector3i &first = obstacles.first, &size = obstacles.size;
  const std::int16_t* from = obstacles.squared.data();
  for (int z = 0; z <= size.z(); ++z)
    for (int y = 0; y <= size.y(); ++y, from += size.x() + 1) {
      std::int16_t* const into =
          all->data() + (static_cast<std::ptrdiff_t>(first.z() + z) * ny_ + first.y() + y) * nx_ + first.x();
      for (int x = 0; x <= size.x(); ++x) into[x] = std::min(into[x], from[x]);
    }
  squared_ = all;
}

float DistanceField::squared_cells(const Eigen::Vector3f& p_W) const {
  const Eigen::Vector3f at = (p_W - origin_) * per_m_;
  const Eigen::Vector3f last(static_cast<float>(nx_ - 1), static_cast<float>(ny_ - 1),
                             static_cast<float>(nz_ - 1));
  const Eigen::Vector3f in = at.cwiseMax(0.0f).cwiseMin(last);
  const int ix = std::min(static_cast<int>(in.x()), nx_ - 2),
            iy = std::min(static_cast<int>(in.y()), ny_ - 2),
            iz = std::min(static_cast<int>(in.z()), nz_ - 2);
  const float tx = in.x() - static_cast<float>(ix), ty = in.y() - static_cast<float>(iy),
              tz = in.z() - static_cast<float>(iz);
  const std::int16_t* v = squared_->data() + (static_cast<std::ptrdiff_t>(iz) * ny_ + iy) * nx_ + ix;
  const auto along_x = [&](std::ptrdiff_t offset) {
    const auto a = static_cast<float>(v[offset]), b = static_cast<float>(v[offset + 1]);
    return a + tx * (b - a);
  };
  const std::ptrdiff_t up = static_cast<std::ptrdiff_t>(ny_) * nx_;
  const float low = along_x(0) + ty * (along_x(nx_) - along_x(0));
  const float high = along_x(up) + ty * (along_x(up + nx_) - along_x(up));
  const float mean = low + tz * (high - low);
  const float inside = mean - tx * (1 - tx) - ty * (1 - ty) - tz * (1 - tz) - kRounding;
  // all obstacles lie on the grid's side of its nearest point
  return std::max(inside, 0.0f) + (at - in).squaredNorm();
}

float DistanceField::distance(const Eigen::Vector3f& p_W) const {
  if (empty()) return max_m_;
  return std::min(max_m_, cell_m_ * std::sqrt(squared_cells(p_W)));
}

bool DistanceField::clear(const Eigen::Vector3f& p_W, float radius_m) const {
  if (empty()) return true;
  const float cells = radius_m * per_m_;
  return squared_cells(p_W) >= cells * cells;
}

void DistanceField::look_up(const float* x, const float* y, const float* z, int count,
                            std::int16_t* squared) const {
  if (empty()) {
    std::fill_n(squared, count, std::int16_t{32767});
    return;
  }
  const std::int16_t* const all = squared_->data();
  constexpr int kAtOnce = 16;  // points of one batch; no result depends on it
  const float ox = 0.5f - origin_.x() * per_m_, oy = 0.5f - origin_.y() * per_m_,
              oz = 0.5f - origin_.z() * per_m_;
  const float lx = static_cast<float>(nx_) - 0.5f, ly = static_cast<float>(ny_) - 0.5f,
              lz = static_cast<float>(nz_) - 0.5f;
  for (int first = 0; first < count; first += kAtOnce) {
    const int n = std::min(kAtOnce, count - first);
    int ix[kAtOnce], iy[kAtOnce], iz[kAtOnce];
    for (int i = 0; i < n; ++i) {
      ix[i] = static_cast<int>(std::min(std::max(x[first + i] * per_m_ + ox, 0.0f), lx));
      iy[i] = static_cast<int>(std::min(std::max(y[first + i] * per_m_ + oy, 0.0f), ly));
      iz[i] = static_cast<int>(std::min(std::max(z[first + i] * per_m_ + oz, 0.0f), lz));
    }
    for (int i = 0; i < n; ++i) {
      squared[first + i] = all[(static_cast<std::ptrdiff_t>(iz[i]) * ny_ + iy[i]) * nx_ + ix[i]];
    }
  }
}

std::int16_t DistanceField::enough(float radius_m) const {
  // no point is farther from its nearest corner than half a cell's diagonal, and the distance changes by no
  // more than the way; the hair on top is for rounding
  const float cells = radius_m * per_m_ + 0.8661f;
  const float squared = std::ceil(cells * cells + 0.01f);
  return static_cast<std::int16_t>(std::min(squared, 32767.0f));
}

}  // namespace colift::planner
