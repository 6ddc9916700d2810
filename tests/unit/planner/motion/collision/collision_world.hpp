#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

#include "hal/robot_model/robot_model.hpp"
#include "perception/map/world_map.hpp"
#include "planner/motion/collision/collision_scene.hpp"
#include "sim_hal/synthetic/hash_random.hpp"
#include "sim_hal/synthetic/ray_caster.hpp"

namespace colift::test {

/// A table within the arm's reach with clutter around it, seen by one camera, as a collision world.
struct CollisionWorld {
  sim_hal::World world;
  perception::OrganisedCloud cloud;
  std::vector<std::uint32_t> target_pixels;
  perception::WorldMap map{perception::WorldMapConfig{}};
  hal::Plane ground{hal::Vec3::UnitZ(), 0.0};

  CollisionWorld() {
    using namespace sim_hal;
    world.shapes = {
        half_space({0, 0, 0}, hal::Vec3::UnitZ(), Label::Ground),
        box({0.75, 0.0, 0.44}, {0.5, 0.8, 0.03}, 0.35, Label::Target),
        box({0.60, -0.35, 0.22}, {0.04, 0.04, 0.41}, 0.35, Label::Target),
        box({0.90, 0.35, 0.22}, {0.04, 0.04, 0.41}, 0.35, Label::Target),
        box({0.2, 0.6, 0.25}, {0.2, 0.3, 0.5}, 0.6, Label::Clutter),
        cylinder({0.1, -0.6, 0.3}, hal::Vec3::UnitZ(), 0.06, 0.6, Label::Clutter),
        box({-0.6, 0.1, 0.5}, {0.1, 0.8, 1.0}, 0.1, Label::Wall),
        sphere({0.4, -0.3, 0.9}, 0.08, Label::Clutter),
    };
    hal::CameraIntrinsics k{640, 480, 525.0, 525.0, 319.5, 239.5};
    const Rendering seen = cast_rays(world, k, look_at({2.0, -0.9, 1.5}, {0.4, 0.0, 0.4}));
    hal::DepthFrame frame;
    frame.intrinsics = k;
    frame.depth_m = seen.depth_m;
    cloud = perception::deproject(frame, seen.X_WC);
    std::vector<hal::Vec3> points;
    for (std::size_t i = 0; i < seen.label.size(); ++i) {
      if (seen.label[i] != Label::Target) continue;
      target_pixels.push_back(static_cast<std::uint32_t>(i));
      points.push_back(cloud.point(i));
    }
    map.insert(cloud, target_pixels);
    map.carve_robot(hal::built_in_robot(), hal::JointVector::Zero(), {});
    map.set_target(points);
  }

  [[nodiscard]] std::shared_ptr<const planner::CollisionScene> scene(
      const planner::SceneConfig& config = {}) const {
    return std::make_shared<planner::CollisionScene>(planner::make_collision_scene(map, ground, {}, config));
  }
};

/// Uniform within the arm's limits.
inline hal::JointVector draw_joints(sim_hal::Draws& draws) {
  const hal::JointVector lower = hal::built_in_robot().lower_rad(), upper = hal::built_in_robot().upper_rad();
  hal::JointVector q;
  for (int i = 0; i < hal::kArmJoints; ++i) q[i] = draws.between(lower[i], upper[i]);
  return q;
}

/// A joint position with the palm within 15 cm of the table top's near edge, and small changes of it.
class NearTable {
 public:
  explicit NearTable(std::uint64_t seed) : draws_(seed, 7) {}
  hal::JointVector next() {
    constexpr int kChanges = 40;
    if (changes_ == 0) {
      do {
        base_ = draw_joints(draws_);
      } while ((hal::hand_pose(hal::built_in_robot(), base_).translation() - hal::Vec3(0.6, -0.05, 0.47))
                   .cwiseAbs()
                   .maxCoeff() > 0.25);
    }
    changes_ = (changes_ + 1) % kChanges;
    hal::JointVector q = base_;
    for (int i = 0; i < hal::kArmJoints; ++i) q[i] += draws_.between(-0.12, 0.12);
    return q.cwiseMax(hal::built_in_robot().lower_rad()).cwiseMin(hal::built_in_robot().upper_rad());
  }

 private:
  sim_hal::Draws draws_;
  hal::JointVector base_ = hal::JointVector::Zero();
  int changes_ = 0;
};

}  // namespace colift::test
