#include "perception/motion/moved_object.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace colift::perception {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr int kEnclosed = 5;  // of 8 neighbours, the majority: a hole that the sampling left

template <class Visit>
void for_neighbours(int width, int height, std::size_t pixel, int reach, const Visit& visit) {
  const int u = static_cast<int>(pixel) % width, v = static_cast<int>(pixel) / width;
  for (int dv = -reach; dv <= reach; ++dv)
    for (int du = -reach; du <= reach; ++du) {
      if ((du == 0 && dv == 0) || u + du < 0 || v + dv < 0 || u + du >= width || v + dv >= height) continue;
      visit(static_cast<std::size_t>(v + dv) * static_cast<std::size_t>(width) +
            static_cast<std::size_t>(u + du));
    }
}

// The object alone, where it stands now.
std::vector<float> draw(const OrganisedCloud& cloud, std::span<const std::uint32_t> object,
                        const hal::Pose& X, float max_step_m) {
  std::vector<float> depth(cloud.size(), kNan);
  std::vector<std::size_t> drawn;
  for (const std::uint32_t p : object) {
    if (!cloud.seen(p)) continue;
    const auto at = cloud.project(X * cloud.point(p));
    if (!(at.depth_m > 0.0) || !cloud.contains(at.u, at.v)) continue;
    const auto pixel = static_cast<std::size_t>(std::lround(at.v)) * static_cast<std::size_t>(cloud.width()) +
                       static_cast<std::size_t>(std::lround(at.u));
    const auto d = static_cast<float>(at.depth_m);
    if (!(depth[pixel] <= d)) depth[pixel] = d;
    drawn.push_back(pixel);
  }
  // where the image is stretched a row or a column stays empty between two that were drawn
  std::vector<float> filled = depth;
  for (const std::size_t p : drawn)
    for_neighbours(cloud.width(), cloud.height(), p, 1, [&](std::size_t hole) {
      if (filled[hole] == filled[hole]) return;
      float sum = 0.0F, near = std::numeric_limits<float>::infinity(), far = 0.0F;
      int n = 0;
      for_neighbours(cloud.width(), cloud.height(), hole, 1, [&](std::size_t q) {
        if (!(depth[q] == depth[q])) return;
        sum += depth[q];
        near = std::min(near, depth[q]);
        far = std::max(far, depth[q]);
        ++n;
      });
      if (n >= kEnclosed && far - near < max_step_m) filled[hole] = sum / static_cast<float>(n);
    });
  return filled;
}

}  // namespace

hal::DepthFrame move_object(const OrganisedCloud& cloud, std::span<const std::uint32_t> object,
                            const hal::Pose& X, const MovedObjectConfig& config) {
  hal::DepthFrame out;
  out.intrinsics = cloud.intrinsics;
  out.depth_m = cloud.depth_m;
  for (const std::uint32_t p : object)
    for_neighbours(cloud.width(), cloud.height(), p, config.rim_px,
                   [&](std::size_t q) { out.depth_m[q] = kNan; });
  for (const std::uint32_t p : object) out.depth_m[p] = kNan;
  const std::vector<float> moved = draw(cloud, object, X, static_cast<float>(config.max_depth_step_m));
  for (std::size_t p = 0; p < moved.size(); ++p)
    if (moved[p] == moved[p] && !(out.depth_m[p] <= moved[p])) out.depth_m[p] = moved[p];
  return out;
}

}  // namespace colift::perception
