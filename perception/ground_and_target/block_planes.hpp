#pragma once

#include <vector>

#include "perception/noise_model.hpp"
#include "perception/organised_cloud.hpp"

namespace colift::perception {

/// A plane through the points of one square block of the image.
struct BlockPlane {
  Eigen::Vector3f center;  ///< Mean of the block's points in W (m).
  Eigen::Vector3f normal;  ///< Unit, towards the camera.
  float depth_m;           ///< Mean depth along Cz.
  float area_m2;           ///< Surface that the block's seen pixels cover.
  int u, v;                ///< Block column and row.
};

inline constexpr int kBlockPixels = 16;

/// Planes of all blocks whose points lie on one, as far as the noise model tells. Row by row, deterministic.
[[nodiscard]] std::vector<BlockPlane> fit_block_planes(const OrganisedCloud& cloud, const NoiseModel& noise);

}  // namespace colift::perception
