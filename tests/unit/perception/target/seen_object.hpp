#pragma once

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdint>
#include <functional>
#include <vector>

#include "perception/ground/image_border.hpp"
#include "perception/reference_image.hpp"
#include "perception/target/person/limb_shape.hpp"
#include "perception/target/person/person_shape.hpp"
#include "perception/target/regions/open_runs.hpp"
#include "perception/target/regions/thickness.hpp"
#include "sim_hal/synthetic/kinect/kinect_noise.hpp"

namespace colift::perception {

/// The largest region that stands on the floor, as a Kinect measures it.
struct SeenObject {
  OrganisedCloud cloud;
  Components components;
  Fragment object;
  DepthJump jump{0.013f, 0.008f};
  Ground ground{{Vec3::UnitZ(), 0.0}, 1000, 0.002};

  explicit SeenObject(const std::vector<sim_hal::Shape>& shapes, std::uint64_t seed = 3)
      : SeenObject(shapes, seed, sim_hal::look_at(Vec3(-0.6, 0, 0.9), Vec3(1.2, 0, 0.3)), 1, 0.03f) {}

  /// In the mean of some frames; of what is `raised_m` above the floor.
  SeenObject(const std::vector<sim_hal::Shape>& shapes, std::uint64_t seed, const Pose& X_WC, int frames,
             float raised_m) {
    sim_hal::World world;
    world.shapes.push_back(sim_hal::half_space(Vec3::Zero(), Vec3::UnitZ(), sim_hal::Label::Ground));
    world.shapes.insert(world.shapes.end(), shapes.begin(), shapes.end());
    const sim_hal::Rendering truth = sim_hal::cast_rays(world, {}, X_WC);
    std::vector<hal::DepthFrame> taken;
    for (int n = 0; n < frames; ++n)
      taken.push_back(sim_hal::measure(truth, {}, seed + 1000 * static_cast<std::uint64_t>(n)));
    if (frames == 1) {
      cloud = deproject(taken.front(), X_WC);
    } else {
      auto reference = build_reference(taken, X_WC, NoiseModel(), ReferenceConfig());
      REQUIRE(reference);
      cloud = std::move(reference->cloud);
    }
    std::vector<std::uint8_t> mask(cloud.size(), 0);
    for (std::size_t i = 0; i < mask.size(); ++i) mask[i] = cloud.seen(i) && cloud.z[i] > raised_m ? 1 : 0;
    components = connected_components(cloud.depth_m, mask, cloud.width(), cloud.height(), jump);
    auto all = describe_fragments(cloud, components, ground, find_image_border(cloud), {});
    all = join_fragments(std::move(all), cloud, components, ground, NoiseModel(), {});
    REQUIRE_FALSE(all.empty());
    object = *std::max_element(all.begin(), all.end(),
                               [](const auto& a, const auto& b) { return a.pixels < b.pixels; });
  }

  [[nodiscard]] Silhouette silhouette() const { return {cloud, components, object, ground}; }
  [[nodiscard]] SurfaceCurvature curvature() const {
    return surface_curvature(cloud, components, object, NoiseModel());
  }
  [[nodiscard]] std::optional<LimbShape> limb(const LimbShapeConfig& config = {}) const {
    return find_limb(cloud, components, object, silhouette(), NoiseModel(), config);
  }
  [[nodiscard]] std::optional<HeadAndShoulders> person(const PersonShapeConfig& config = {}) const {
    const Silhouette s = silhouette();
    const auto thickness = [&](const Silhouette::Window& window) {
      return median_thickness(cloud, components, object, jump, s, window);
    };
    return find_person(s, NoiseModel(), thickness, config);
  }
};

/// As a run sees it: in the mean of some frames, from a little above the floor on.
constexpr int kFrames = 10;
constexpr float kRaised_m = 0.012f;

/// For how many of ten seeds of the noise something holds.
inline int of_ten(const std::function<bool(std::uint64_t)>& holds) {
  int n = 0;
  for (std::uint64_t seed = 1; seed <= 10; ++seed) n += holds(seed) ? 1 : 0;
  return n;
}

}  // namespace colift::perception
