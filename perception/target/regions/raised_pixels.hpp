#pragma once

#include <cstdint>
#include <vector>

#include "perception/noise_model.hpp"
#include "perception/organised_cloud.hpp"
#include "perception/scene.hpp"
#include "perception/target/regions/components.hpp"

namespace colift::perception {

/// How high a pixel stands above the ground before it is no longer ground.
struct Clearance {
  double base_m = 0.006;
  double sigma_factor = 3.0;  ///< Times the noise of the pixel's height.
};

/// 1 for each pixel that stands above the ground by more than the clearance; 0 for missing ones.
[[nodiscard]] std::vector<std::uint8_t> raised_pixels(const OrganisedCloud& cloud, const Ground& ground,
                                                      const NoiseModel& noise, const Clearance& clearance);

/// Takes pixels with few neighbours at their own depth out of the mask: flying pixels between an edge and its
/// background, speckle.
void clear_flying_pixels(const OrganisedCloud& cloud, const DepthJump& jump, int min_neighbours,
                         std::vector<std::uint8_t>& mask);

}  // namespace colift::perception
