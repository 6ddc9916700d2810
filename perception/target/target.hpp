#pragma once

#include <optional>
#include <string>
#include <vector>

#include "perception/ground/block_planes.hpp"
#include "perception/noise_model.hpp"
#include "perception/organised_cloud.hpp"
#include "perception/scene.hpp"
#include "perception/target/objections.hpp"
#include "perception/target/target_config.hpp"

namespace colift::perception {

/// The target, where there is one, and the objects that were refused.
struct TargetResult {
  std::optional<Target> target;  ///< Without surfaces and completion: shape equals obb, cog its centre.
  std::vector<RejectedObject> rejected;  ///< Largest first.
  std::string reason;
};

/// The object to be carried: the largest free-standing one on the ground, or the one nearest to `at_W`.
/// Objects are connected regions of the image above the ground, cut apart at depth jumps that the noise does
/// not explain, cleaned of flying pixels, freed from walls, and joined over holes and hidden parts.
[[nodiscard]] TargetResult find_target(const OrganisedCloud& cloud, const std::vector<BlockPlane>& blocks,
                                       const Ground& ground, const NoiseModel& noise,
                                       const TargetConfig& config,
                                       const std::optional<Vec3>& at_W = std::nullopt);

/// Points, boxes and first guess of the centre of gravity of a target whose pixels are known.
void measure_target(Target& target, const OrganisedCloud& cloud, const Ground& ground, const BoxTrim& trim);

}  // namespace colift::perception
