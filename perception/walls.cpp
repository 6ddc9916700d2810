#include "perception/walls.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "perception/plane_vote.hpp"

namespace colift::perception {
namespace {

constexpr double kUpright = 0.17;  // |cosine| between a wall's normal and up: 10 degrees
constexpr double kLowest_m = 0.05; // blocks below are the ground's
constexpr double kCovered = 0.15;  // part of its frame that a wall's blocks cover at least; much of it is hidden by things

}  // namespace

std::vector<Plane> find_walls(const OrganisedCloud& cloud, const std::vector<BlockPlane>& blocks, const Ground& ground,
                              const ImageBorder& border, const NoiseModel& noise, const WallConfig& config) {
  const Vec3 up = ground.plane.normal;
  std::vector<BlockPlane> raised;
  for (const BlockPlane& b : blocks)
    if (ground.plane.height(b.center.cast<double>()) > kLowest_m) raised.push_back(b);

  const auto upright = [&](const Vec3& n) { return std::abs(n.dot(up)) < kUpright; };
  std::vector<Plane> walls;
  for (const VotedPlane& p : vote_planes(raised, upright, noise, {config.tolerance_m, 3.0})) {
    const Vec3 along = up.cross(p.plane.normal).normalized();
    double lo = std::numeric_limits<double>::infinity(), hi = -lo, bottom = lo, top = -lo;
    bool cut_top = false;
    for (const BlockPlane* b : p.blocks) {
      const Vec3 c = b->center.cast<double>();
      const double half = 0.5 * kBlockPixels * b->depth_m / cloud.intrinsics.fx;
      lo = std::min(lo, along.dot(c) - half);
      hi = std::max(hi, along.dot(c) + half);
      bottom = std::min(bottom, ground.plane.height(c) - half);
      top = std::max(top, ground.plane.height(c) + half);
      const int column = std::min(b->u * kBlockPixels + kBlockPixels / 2, cloud.width() - 1);
      cut_top |= b->v * kBlockPixels <= border.top[static_cast<std::size_t>(column)] + kBlockPixels;
    }
    if (hi - lo < config.min_width_m) continue;
    if (top < config.min_height_m && !cut_top) continue;
    if (p.area_m2 < kCovered * (hi - lo) * (top - bottom)) continue;
    walls.push_back(p.plane);
  }
  return walls;
}

std::size_t clear_walls(const OrganisedCloud& cloud, const std::vector<Plane>& walls, const NoiseModel& noise,
                        const WallConfig& config, std::vector<std::uint8_t>& mask) {
  const float sigma0 = static_cast<float>(config.tolerance_m + 3.0 * noise.sigma0_m);
  const float sigma2 = static_cast<float>(3.0 * noise.sigma2_per_m);
  struct Coefficients {
    float x, y, z, offset;
  };
  std::vector<Coefficients> planes;
  for (const Plane& wall : walls) {
    const Eigen::Vector3f n = wall.normal.cast<float>();
    planes.push_back({n.x(), n.y(), n.z(), static_cast<float>(wall.offset)});
  }
  std::size_t cleared = 0;
  for (std::size_t i = 0; i < cloud.size() && !planes.empty(); ++i) {
    if (!mask[i]) continue;
    const float reach = sigma0 + sigma2 * cloud.depth_m[i] * cloud.depth_m[i];
    for (const Coefficients& p : planes) {
      if (std::abs(p.x * cloud.x[i] + p.y * cloud.y[i] + p.z * cloud.z[i] + p.offset) > reach) continue;
      mask[i] = 0;
      ++cleared;
      break;
    }
  }
  return cleared;
}

}  // namespace colift::perception
