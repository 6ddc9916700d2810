#pragma once

#include <functional>
#include <vector>

#include "perception/ground_and_target/block_planes.hpp"
#include "perception/noise_model.hpp"
#include "perception/scene.hpp"

namespace colift::perception {

/// A plane that several image blocks agree on.
struct VotedPlane {
  Plane plane;
  double area_m2 = 0.0;                   ///< Surface of the blocks that voted for it.
  std::vector<const BlockPlane*> blocks;  ///< Those blocks.
};

/// Distance from a plane within which a block or pixel belongs to it: base + sigma_factor * noise at its
/// depth.
struct PlaneTolerance {
  double base_m = 0.006;
  double sigma_factor = 3.0;

  [[nodiscard]] double at(const NoiseModel& noise, double depth_m) const {
    return base_m + sigma_factor * noise.sigma(depth_m);
  }
};

/// Planes that the blocks vote for, largest area first, each once. `wanted` decides by the unit normal
/// (towards the camera) which blocks may propose and which planes may result. Deterministic: no random draws,
/// every k-th block proposes.
[[nodiscard]] std::vector<VotedPlane> vote_planes(const std::vector<BlockPlane>& blocks,
                                                  const std::function<bool(const Vec3&)>& wanted,
                                                  const NoiseModel& noise, const PlaneTolerance& tolerance);

}  // namespace colift::perception
