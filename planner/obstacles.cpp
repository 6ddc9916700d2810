#include "planner/obstacles.hpp"

#include <numeric>

namespace colift::planner {

void Obstacles::add(const Eigen::Vector3f& p, ObstacleKind kind) {
  points_.push_back(p);
  kinds_.push_back(kind);
}

void Obstacles::build() {
  buckets_.clear();
  if (points_.empty()) return;
  Eigen::Vector3f low = points_.front(), high = low;
  for (const auto& p : points_) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  origin_ = low.cast<double>();
  for (int a = 0; a < 3; ++a) n_[a] = cell_of(high[a], a) + 1;

  // stable counting sort by x, then by row: linear, and small even when the object fills a hall
  const std::size_t rows = static_cast<std::size_t>(n_[1]) * static_cast<std::size_t>(n_[2]);
  std::vector<std::uint32_t> column(points_.size()), row(points_.size()), by_column(points_.size()),
      order(points_.size());
  std::vector<std::uint32_t> column_begin(static_cast<std::size_t>(n_[0]) + 1, 0), begin(rows + 1, 0);
  for (std::size_t i = 0; i < points_.size(); ++i) {
    const Eigen::Vector3d p = points_[i].cast<double>();
    column[i] = static_cast<std::uint32_t>(cell_of(p.x(), 0));
    row[i] = static_cast<std::uint32_t>(cell_of(p.z(), 2) * n_[1] + cell_of(p.y(), 1));
    ++column_begin[column[i] + 1];
    ++begin[row[i] + 1];
  }
  std::partial_sum(column_begin.begin(), column_begin.end(), column_begin.begin());
  std::partial_sum(begin.begin(), begin.end(), begin.begin());
  for (std::uint32_t i = 0; i < points_.size(); ++i) by_column[column_begin[column[i]]++] = i;
  std::vector<std::uint32_t> next(begin.begin(), begin.end() - 1);
  for (const std::uint32_t i : by_column) order[next[row[i]]++] = i;

  row_begin_.assign(rows + 1, 0);
  std::vector<Eigen::Vector3f> points(points_.size());
  std::vector<ObstacleKind> kinds(points_.size());
  for (std::size_t r = 0; r < rows; ++r) {
    const int iy = static_cast<int>(r) % n_[1], iz = static_cast<int>(r) / n_[1];
    for (std::uint32_t slot = begin[r]; slot < begin[r + 1]; ++slot) {
      points[slot] = points_[order[slot]];
      kinds[slot] = kinds_[order[slot]];
      const int ix = static_cast<int>(column[order[slot]]);
      if (slot > begin[r] && buckets_.back().ix == ix) {
        ++buckets_.back().end;
        continue;
      }
      const hal::Vec3 center = origin_ + kCell * hal::Vec3(ix + 0.5, iy + 0.5, iz + 0.5);
      buckets_.push_back({ix, slot, slot + 1, center.cast<float>()});
    }
    row_begin_[r + 1] = static_cast<std::uint32_t>(buckets_.size());
  }
  points_ = std::move(points);
  kinds_ = std::move(kinds);
}

namespace {

/// True when at least `needed` of the eight neighbours lie at a like depth.
bool supported(const perception::OrganisedCloud& cloud, int u, int v, float tolerance, int needed) {
  const float depth = cloud.depth_m[static_cast<std::size_t>(v) * static_cast<std::size_t>(cloud.width()) +
                                    static_cast<std::size_t>(u)];
  int found = 0;
  for (int dv = -1; dv <= 1; ++dv) {
    for (int du = -1; du <= 1; ++du) {
      const int nu = u + du, nv = v + dv;
      if ((du == 0 && dv == 0) || nu < 0 || nv < 0 || nu >= cloud.width() || nv >= cloud.height()) continue;
      const float other =
          cloud.depth_m[static_cast<std::size_t>(nv) * static_cast<std::size_t>(cloud.width()) +
                        static_cast<std::size_t>(nu)];
      if (std::abs(other - depth) <= tolerance) ++found;  // false for NaN
    }
  }
  return found >= needed;
}

}  // namespace

Obstacles gather_obstacles(const perception::Scene& scene, const perception::OrganisedCloud* cloud,
                           const ObstacleConfig& config) {
  Obstacles obstacles;
  if (scene.ground) obstacles.set_ground(scene.ground->plane);
  if (!scene.target) return obstacles;
  const perception::Target& target = *scene.target;
  for (const auto& p : target.points) obstacles.add(p, ObstacleKind::Object);

  if (cloud != nullptr && config.surroundings) {
    std::vector<bool> of_target(cloud->size(), false);
    for (const std::uint32_t pixel : target.pixels) {
      if (pixel < cloud->size()) of_target[pixel] = true;
    }
    const Eigen::Vector3f low = (target.aabb.min() - hal::Vec3::Constant(config.reach_m)).cast<float>();
    const Eigen::Vector3f high = (target.aabb.max() + hal::Vec3::Constant(config.reach_m)).cast<float>();
    std::size_t pixel = 0;
    for (int v = 0; v < cloud->height(); ++v) {
      for (int u = 0; u < cloud->width(); ++u, ++pixel) {
        const float x = cloud->x[pixel], y = cloud->y[pixel], z = cloud->z[pixel];
        // written so that NaN is left out
        if (!(x >= low.x() && x <= high.x() && y >= low.y() && y <= high.y() && z >= low.z() &&
              z <= high.z()))
          continue;
        if (of_target[pixel]) continue;
        const double depth = cloud->depth_m[pixel];
        if (scene.ground) {
          const double band =
              std::max(config.ground_band_m, config.ground_sigmas * config.noise.sigma(depth));
          if (std::abs(scene.ground->plane.height({x, y, z})) <= band) continue;
        }
        const auto tolerance =
            static_cast<float>(config.support_sigmas * config.noise.sigma(depth) + config.noise.step(depth));
        if (!supported(*cloud, u, v, tolerance, config.min_support)) continue;
        obstacles.add({x, y, z}, ObstacleKind::Surroundings);
      }
    }
  }
  obstacles.build();
  return obstacles;
}

}  // namespace colift::planner
