#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "perception/noise_model.hpp"
#include "perception/organised_cloud.hpp"
#include "perception/scene.hpp"
#include "perception/surfaces/surface_config.hpp"

namespace colift::perception {

/// The pipe of a target that is a pipe on its stands.
struct LyingPipe {
  Cylinder cylinder;
  std::vector<std::uint32_t> pixels;  ///< Of the target's, ascending.
};

/// Nothing where the target is not one level cylinder, clear of the ground, with all else of it below. The
/// pixels of stands that go on, in one plane, on the mantle make a cylinder of find_surfaces() too thick: it
/// is fitted again to the stretches under which nothing of the target stands.
/// Whether stands are joined to it nobody sees: what is joined is carried along all the same.
[[nodiscard]] std::optional<LyingPipe> find_lying_pipe(const OrganisedCloud& cloud, const Target& target,
                                                       const std::vector<Surface>& surfaces,
                                                       const Ground& ground, const NoiseModel& noise,
                                                       const SurfaceConfig& config);

}  // namespace colift::perception
