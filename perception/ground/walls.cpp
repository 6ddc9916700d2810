#include "perception/ground/walls.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "perception/ground/plane_vote.hpp"

namespace colift::perception {
namespace {

Vec3 middle(const std::vector<const BlockPlane*>& blocks) {
  Vec3 sum = Vec3::Zero();
  for (const BlockPlane* b : blocks) sum += b->center.cast<double>();
  return sum / static_cast<double>(std::max<std::size_t>(1, blocks.size()));
}

// the largest group of blocks that hang together in the image
std::vector<const BlockPlane*> largest_group(std::vector<const BlockPlane*> blocks, int reach) {
  std::vector<const BlockPlane*> best;
  while (!blocks.empty()) {
    std::vector<const BlockPlane*> group{blocks.back()};
    blocks.pop_back();
    for (std::size_t i = 0; i < group.size(); ++i) {
      const auto near = [&](const BlockPlane* b) {
        return std::abs(b->u - group[i]->u) <= reach && std::abs(b->v - group[i]->v) <= reach;
      };
      const auto rest =
          std::stable_partition(blocks.begin(), blocks.end(), [&](const auto* b) { return !near(b); });
      group.insert(group.end(), rest, blocks.end());
      blocks.erase(rest, blocks.end());
    }
    if (group.size() > best.size()) best = std::move(group);
  }
  return best;
}

}  // namespace

std::vector<Wall> find_walls(const OrganisedCloud& cloud, const std::vector<BlockPlane>& blocks,
                             const Ground& ground, const ImageBorder& border, const NoiseModel& noise,
                             const WallConfig& config) {
  const Vec3 up = ground.plane.normal;
  std::vector<BlockPlane> raised;
  for (const BlockPlane& b : blocks)
    if (ground.plane.height(b.center.cast<double>()) > config.min_block_height_m) raised.push_back(b);

  const auto upright = [&](const Vec3& n) { return std::abs(n.dot(up)) < config.max_lean_sine; };
  std::vector<const BlockPlane*>
      claimed;  // a block belongs to one wall: no plane grows from the rest of another
  std::vector<Wall> walls;
  for (const VotedPlane& p :
       vote_planes(raised, upright, noise, {config.tolerance_m, config.tolerance_sigma}, config.vote)) {
    // a long wall looks bent through a real lens: nearly the same plane again is more of the same wall
    const bool more = std::any_of(walls.begin(), walls.end(), [&](const Wall& w) {
      return w.plane.normal.dot(p.plane.normal) > config.same_wall_cosine &&
             std::abs(w.plane.height(middle(p.blocks))) < config.same_wall_distance_m;
    });
    std::vector<const BlockPlane*> own;
    for (const BlockPlane* b : p.blocks)
      if (more || std::find(claimed.begin(), claimed.end(), b) == claimed.end()) own.push_back(b);
    const std::vector<const BlockPlane*> core = largest_group(own, config.max_gap_blocks);

    const Vec3 along = up.cross(p.plane.normal).normalized();
    double lo = std::numeric_limits<double>::infinity(), hi = -lo, bottom = lo, top = -lo, area = 0.0;
    bool cut_top = false;
    for (const BlockPlane* b : core) {
      const Vec3 c = b->center.cast<double>();
      const double half = 0.5 * kBlockPixels * b->depth_m / cloud.intrinsics.fx;
      lo = std::min(lo, along.dot(c) - half);
      hi = std::max(hi, along.dot(c) + half);
      bottom = std::min(bottom, ground.plane.height(c) - half);
      top = std::max(top, ground.plane.height(c) + half);
      area += b->area_m2;
      const int column = std::min(b->u * kBlockPixels + kBlockPixels / 2, cloud.width() - 1);
      cut_top |= b->v * kBlockPixels <= border.top[static_cast<std::size_t>(column)] + kBlockPixels;
    }
    if (core.size() < static_cast<std::size_t>(config.min_blocks)) continue;
    if (!more) {
      if (hi - lo < config.min_width_m) continue;
      if (top < config.min_height_m && !cut_top) continue;
      if (area < config.min_covered_fraction * (hi - lo) * (top - bottom)) continue;
    }
    // a thing in front may part a wall in two: it reaches to its last block. The plane of a wall's second
    // part may run through an object, so that one ends where its blocks do.
    for (const BlockPlane* b : more ? core : own) {
      lo = std::min(lo, along.dot(b->center.cast<double>()));
      hi = std::max(hi, along.dot(b->center.cast<double>()));
    }
    walls.push_back({p.plane, along, lo - config.end_margin_m, hi + config.end_margin_m});
    claimed.insert(claimed.end(), p.blocks.begin(), p.blocks.end());
  }
  return walls;
}

std::size_t clear_walls(const OrganisedCloud& cloud, const std::vector<Wall>& walls, const NoiseModel& noise,
                        const WallConfig& config, std::vector<std::uint8_t>& mask) {
  const float sigma0 = static_cast<float>(config.tolerance_m + config.tolerance_sigma * noise.sigma0_m);
  const float sigma2 = static_cast<float>(config.tolerance_sigma * noise.sigma2_per_m);
  struct Slab {
    Eigen::Vector3f normal, along;
    float offset, from, to;
  };
  std::vector<Slab> slabs;
  for (const Wall& w : walls) {
    slabs.push_back({w.plane.normal.cast<float>(), w.along.cast<float>(), static_cast<float>(w.plane.offset),
                     static_cast<float>(w.from_m), static_cast<float>(w.to_m)});
  }
  if (slabs.empty()) return 0;
  std::size_t cleared = 0;
  const std::size_t w = static_cast<std::size_t>(cloud.width());
  std::vector<std::int32_t> row_hit(w);
  std::int32_t* hit = row_hit.data();
  for (std::size_t row = 0; row < cloud.size(); row += w) {
    const float *d = cloud.depth_m.data() + row, *x = cloud.x.data() + row, *y = cloud.y.data() + row,
                *z = cloud.z.data() + row;
    std::uint8_t* m = mask.data() + row;
    if (!std::memchr(m, 1, w)) continue;
    std::fill(row_hit.begin(), row_hit.end(), 0);
    for (const Slab& s : slabs) {
      const float nx = s.normal.x(), ny = s.normal.y(), nz = s.normal.z(), ax = s.along.x(), ay = s.along.y(),
                  az = s.along.z(), offset = s.offset, from = s.from, to = s.to;
      // every condition is evaluated, so that the loop has no branches
      for (std::size_t u = 0; u < w; ++u) {
        const float away = std::abs(nx * x[u] + ny * y[u] + nz * z[u] + offset);
        const float along = ax * x[u] + ay * y[u] + az * z[u];
        const std::int32_t near = away <= sigma0 + sigma2 * d[u] * d[u] ? 1 : 0;
        const std::int32_t begun = along >= from ? 1 : 0, not_over = along <= to ? 1 : 0;
        hit[u] |= near & begun & not_over;
      }
    }
    std::int32_t here = 0;
    for (std::size_t u = 0; u < w; ++u) {
      const std::int32_t clear = hit[u] & m[u];
      here += clear;
      m[u] = static_cast<std::uint8_t>(m[u] - clear);
    }
    cleared += static_cast<std::size_t>(here);
  }
  return cleared;
}

}  // namespace colift::perception
