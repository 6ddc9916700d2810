#pragma once

#include "perception/organised_cloud.hpp"
#include "perception/scene.hpp"
#include "sim_hal/synthetic/scenes.hpp"

namespace colift::tests {

/// What a flawless perception would say of a synthetic scene: the faces and cylinders of the truth, cut to
/// what the camera sees of them, with the measured cloud.
struct SeenScene {
  sim_hal::SyntheticScene truth;
  perception::OrganisedCloud cloud;
  perception::Scene scene;
};

[[nodiscard]] SeenScene see(const sim_hal::SyntheticScene& truth, bool noise, std::uint64_t seed = 1);

/// A scene of one object on the floor z = 0, typed by hand.
[[nodiscard]] sim_hal::SyntheticScene scene_of(const std::vector<sim_hal::Shape>& shapes,
                                               const hal::Vec3& eye, const hal::Vec3& look_at);

/// Adds the six faces of a box to the truth.
void add_faces(sim_hal::SyntheticScene& scene, const hal::Vec3& center, const hal::Vec3& size);

}  // namespace colift::tests
