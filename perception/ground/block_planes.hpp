#pragma once

#include <vector>

#include "hal/config/range.hpp"
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

/// Side of a block: a power of two, so that its rows fill whole SIMD registers.
inline constexpr int kBlockPixels = 16;

/// Which blocks of the image count as flat.
struct BlockPlaneConfig {
  double min_seen_fraction = 0.6;
  double max_misfit_sigma = 2.5;
  double min_spread_ratio = 4.0;

  template <class Visitor>
  void visit(Visitor& v) {
    v("min_seen_fraction", min_seen_fraction, hal::kFraction,
      "Min fraction of an image block's pixels with a depth, for a plane to be fitted to it.");
    v("max_misfit_sigma", max_misfit_sigma, hal::Range{0.1, 100},
      "Max root mean square residual of an image block's plane, in standard deviations of the depth noise.");
    v("min_spread_ratio", min_spread_ratio, hal::Range{1, 1000},
      "Min ratio of the variance of a block's points within its plane, along the short axis, to that across "
      "it.");
  }
};

/// Planes of all blocks whose points lie on one, as far as the noise model tells. Row by row, deterministic.
[[nodiscard]] std::vector<BlockPlane> fit_block_planes(const OrganisedCloud& cloud, const NoiseModel& noise,
                                                       const BlockPlaneConfig& config = {});

}  // namespace colift::perception
