#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "../figures.hpp"
#include "perception/partner/partner_grasp.hpp"
#include "sim_hal/synthetic/scenes.hpp"

namespace colift::perception::test {

/// A synthetic scene as the partner finder sees it: a noisy reference, the object's true pixels, and later
/// frames.
struct Stage {
  sim_hal::SyntheticScene scene;
  ReferenceImage reference;
  Target target;
  Ground ground;

  Stage(sim_hal::ObjectKind kind, std::uint64_t seed, int reference_frames = 5)
      : scene(sim_hal::make_scene(kind, seed)) {
    const auto truth = sim_hal::cast_rays(scene.world, scene.intrinsics, scene.X_WC);
    std::vector<hal::DepthFrame> frames;
    for (int i = 0; i < reference_frames; ++i) {
      frames.push_back(sim_hal::measure(truth, {}, 1000 * seed + static_cast<std::uint64_t>(i)));
    }
    reference = build_reference(frames, scene.X_WC, NoiseModel{}).value();
    ground.plane = scene.ground;
    // ragged edges: a pixel that shows the background is none of the object's, whatever its ray hits without
    // noise
    for (std::uint32_t i = 0; i < truth.depth_m.size(); ++i) {
      if (truth.label[i] != sim_hal::Label::Target) continue;
      if (std::abs(reference.cloud.depth_m[i] - truth.depth_m[i]) > 0.04F || !reference.cloud.seen(i))
        continue;
      target.pixels.push_back(i);
      target.points.emplace_back(reference.cloud.x[i], reference.cloud.y[i], reference.cloud.z[i]);
    }
  }

  [[nodiscard]] PartnerFinder finder(const PartnerConfig& config = {}) const {
    return PartnerFinder::make(reference, target, ground, NoiseModel{}, config).value();
  }

  [[nodiscard]] OrganisedCloud see(const sim_hal::World& world, std::uint64_t seed) const {
    return deproject(sim_hal::measure(sim_hal::cast_rays(world, scene.intrinsics, scene.X_WC), {}, seed),
                     scene.X_WC);
  }
};

/// The rule of thesis 5.3.3: mean of the 100 changed points nearest to the object. Every changed point
/// against every point of the object, thinned to 2 cm.
inline Vec3 thesis_rule(const Stage& stage, const OrganisedCloud& current,
                        const std::vector<std::uint32_t>& changed) {
  std::vector<Eigen::Vector3f> object;
  for (const auto& p : stage.target.points) {
    const bool near =
        std::any_of(object.rbegin(), object.rbegin() + std::min<std::ptrdiff_t>(200, std::ssize(object)),
                    [&](const Eigen::Vector3f& q) { return (p - q).squaredNorm() < 0.02F * 0.02F; });
    if (!near) object.push_back(p);
  }
  std::vector<std::pair<float, std::uint32_t>> by_distance;
  for (const std::uint32_t i : changed) {
    const Eigen::Vector3f p(current.x[i], current.y[i], current.z[i]);
    float nearest = 1e9F;
    for (const auto& q : object) nearest = std::min(nearest, (p - q).squaredNorm());
    by_distance.emplace_back(nearest, i);
  }
  const std::size_t n = std::min<std::size_t>(100, by_distance.size());
  std::partial_sort(by_distance.begin(), by_distance.begin() + static_cast<std::ptrdiff_t>(n),
                    by_distance.end());
  Vec3 sum = Vec3::Zero();
  for (std::size_t i = 0; i < n; ++i) sum += current.point(by_distance[i].second);
  return sum / static_cast<double>(std::max<std::size_t>(1, n));
}

}  // namespace colift::perception::test
