#pragma once

#include <catch2/catch.hpp>
#include <cmath>
#include <string>
#include <vector>

#include "../figures.hpp"
#include "perception/ground/block_planes.hpp"
#include "perception/ground/ground.hpp"
#include "perception/organised_cloud.hpp"
#include "perception/target/target.hpp"
#include "sim_hal/synthetic/scenes.hpp"

namespace colift::perception {

/// A synthetic scene as the camera measures it, with the truth beside it.
struct SceneView {
  sim_hal::SyntheticScene scene;
  sim_hal::Rendering truth;
  OrganisedCloud cloud;

  SceneView(sim_hal::ObjectKind kind, std::uint64_t seed)
      : scene(sim_hal::make_scene(kind, seed)),
        truth(sim_hal::cast_rays(scene.world, scene.intrinsics, scene.X_WC)),
        cloud(deproject(sim_hal::measure(truth, {}, seed), scene.X_WC)) {}
};

/// Intersection over union of the target's pixels with the truth's, over pixels that were seen.
inline double overlap(const SceneView& view, const std::vector<std::uint32_t>& pixels) {
  std::vector<bool> mine(view.cloud.size(), false);
  for (const std::uint32_t p : pixels) mine[p] = true;
  std::size_t both = 0, either = 0;
  for (std::size_t i = 0; i < view.cloud.size(); ++i) {
    if (!view.cloud.seen(i)) continue;
    const bool truth = view.truth.label[i] == sim_hal::Label::Target;
    both += truth && mine[i];
    either += truth || mine[i];
  }
  return either ? static_cast<double>(both) / static_cast<double>(either) : 0.0;
}

}  // namespace colift::perception
