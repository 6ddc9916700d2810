#pragma once

#include <functional>
#include <vector>

#include "hal/config/range.hpp"
#include "perception/ground/block_planes.hpp"
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

/// How planes of image blocks are gathered into large planes.
struct PlaneVoteConfig {
  int proposals = 160;
  int refits = 4;
  int min_blocks = 3;
  double max_normal_angle_deg = 20.0;
  double same_plane_angle_deg = 2.0;
  double same_plane_distance_m = 0.01;

  template <class Visitor>
  void visit(Visitor& v) {
    v("proposals", proposals, hal::Range{1, 10000},
      "Image blocks that propose a plane; more cost time and find smaller planes.");
    v("refits", refits, hal::Range{0, 100},
      "Least-squares fits of a proposed plane to the blocks that vote for it.");
    v("min_blocks", min_blocks, hal::Range{1, 10000}, "Min number of image blocks that vote for a plane.");
    v("max_normal_angle_deg", max_normal_angle_deg, hal::Range{0.1, 90},
      "Max angle between the normals of a plane and of a block that votes for it (deg).");
    v("same_plane_angle_deg", same_plane_angle_deg, hal::Range{0, 45},
      "Max angle between two planes that count as the same one (deg).");
    v("same_plane_distance_m", same_plane_distance_m, hal::Range{0, 1},
      "Max distance between two planes that count as the same one (m).");
  }
};

/// Planes that the blocks vote for, largest area first, each once. `wanted` decides by the unit normal
/// (towards the camera) which blocks may propose and which planes may result. Deterministic: no random draws,
/// every k-th block proposes.
[[nodiscard]] std::vector<VotedPlane> vote_planes(const std::vector<BlockPlane>& blocks,
                                                  const std::function<bool(const Vec3&)>& wanted,
                                                  const NoiseModel& noise, const PlaneTolerance& tolerance,
                                                  const PlaneVoteConfig& config = {});

}  // namespace colift::perception
