#include "perception/thesis/thesis_target.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include "perception/footprint.hpp"
#include "perception/thesis/thesis_surfaces.hpp"

namespace colift::perception {
namespace {

std::string meters(const Vec3& size) {
  return fmt::format("{:.2f} x {:.2f} x {:.2f} m", size.x(), size.y(), size.z());
}

using VoxelKey = std::array<std::int32_t, 3>;

/// Number of the voxel that holds a point; without voxels the bits of the point itself.
VoxelKey voxel_of(float x, float y, float z, double leaf_m) {
  const std::array<float, 3> p{x, y, z};
  VoxelKey key;
  if (leaf_m <= 0) {
    std::memcpy(key.data(), p.data(), sizeof key);
    return key;
  }
  // in single precision as in PCL's grid, so that a point on a face falls on the same side
  const float inverse = 1.0f / static_cast<float>(leaf_m);
  for (std::size_t i = 0; i < 3; ++i) key[i] = static_cast<std::int32_t>(std::floor(p[i] * inverse));
  return key;
}

}  // namespace

Target thesis_target(const std::vector<PclCloud>& clusters, const Ground& ground) {
  Target target;
  target.points = clusters.front().to_vector();
  for (const Eigen::Vector3f& p : target.points) target.aabb.extend(p.cast<double>());
  target.obb = box_on_plane(target.points, ground.plane);
  target.shape = target.obb;
  target.cog = target.aabb.center();
  const Vec3 sigma = target.aabb.sizes() / 6.0;
  target.cog_covariance = sigma.cwiseAbs2().asDiagonal();

  target.reason = fmt::format("largest of {} clusters above the ground: {} points, {}", clusters.size(),
                              target.points.size(), meters(target.obb.size));
  if (clusters.size() == 1)
    target.reason = fmt::format("the only cluster above the ground: {} points, {}", target.points.size(),
                                meters(target.obb.size));
  else
    target.reason += fmt::format("; the next has {}", clusters[1].size());
  return target;
}

Scene thesis_scene(const OrganisedCloud& frame, const ThesisConfig& config) {
  Scene scene;
  const Vec3 eye_W = frame.X_WC.translation();
  const PclCloud seen = points_in_depth_range(frame, config);
  const PclCloud cropped = pass_through(seen, config);
  if (cropped.size() < 4) {
    scene.reason = fmt::format(
        "no ground: of {} pixels {} have a depth between {} and {} m, and {} of these lie inside the crop "
        "box",
        frame.size(), seen.size(), config.depth_min_m, config.depth_max_m, cropped.size());
    return scene;
  }

  const PclCloud thinned = voxel_grid(cropped, config);
  const auto split = split_at_ground(thinned, eye_W, config);
  const double part =
      split ? static_cast<double>(split->ground.inliers) / static_cast<double>(thinned.size()) : 0.0;
  if (!split || part < config.ground_min_fraction) {
    scene.reason =
        split ? fmt::format(
                    "no ground: the largest plane holds {} of {} points ({:.1f} %), a ground holds at least "
                    "{:.1f} %",
                    split->ground.inliers, thinned.size(), 100 * part, 100 * config.ground_min_fraction)
              : fmt::format("no ground: the {} points span no plane", thinned.size());
    return scene;
  }
  scene.ground = split->ground;

  const PclCloud clean = without_outliers(split->above, config);
  const std::vector<PclCloud> clusters = euclidean_clusters(clean, config);
  if (clusters.empty()) {
    scene.reason = fmt::format(
        "no target: {} points lie more than {:.1f} cm above the ground, {} remain without outliers, and no "
        "cluster of them "
        "has {} points",
        split->above.size(), 100 * config.ground_distance_m, clean.size(), config.cluster_min_points);
    return scene;
  }
  scene.target = thesis_target(clusters, *scene.ground);
  for (Rectangle& rectangle : thesis_surfaces(scene.target->points, eye_W, config))
    scene.surfaces.emplace_back(std::move(rectangle));
  scene.reason = scene.target->reason;
  return scene;
}

std::vector<std::uint32_t> thesis_pixels(const OrganisedCloud& frame, const Target& target,
                                         const ThesisConfig& config) {
  std::vector<VoxelKey> voxels;
  voxels.reserve(target.points.size());
  for (const Eigen::Vector3f& p : target.points)
    voxels.push_back(voxel_of(p.x(), p.y(), p.z(), config.voxel_leaf_m));
  std::sort(voxels.begin(), voxels.end());

  std::vector<std::uint32_t> pixels;
  for (std::size_t i = 0; i < frame.size(); ++i) {
    if (!(frame.depth_m[i] >= config.depth_min_m && frame.depth_m[i] <= config.depth_max_m)) continue;
    if (std::binary_search(voxels.begin(), voxels.end(),
                           voxel_of(frame.x[i], frame.y[i], frame.z[i], config.voxel_leaf_m)))
      pixels.push_back(static_cast<std::uint32_t>(i));
  }
  return pixels;
}

}  // namespace colift::perception
