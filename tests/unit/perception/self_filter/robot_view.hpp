#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "hal/robot_model/robot_model.hpp"
#include "perception/self_filter.hpp"
#include "sim_hal/synthetic/hash_random.hpp"
#include "sim_hal/synthetic/scenes.hpp"

namespace colift::perception::test {

using sim_hal::Label;

/// The robot's link shapes as solids of a synthetic world.
inline void add_robot(sim_hal::World& world, const hal::RobotModel& model, const hal::JointVector& q_rad,
                      const hal::HandPosture& hand) {
  std::vector<hal::Pose> X_WL;
  hal::link_poses(model, q_rad, hand, X_WL);
  for (std::size_t i = 0; i < model.links.size(); ++i)
    for (const auto& link_shape : model.links[i].shapes) {
      sim_hal::Shape shape;
      switch (link_shape.kind) {
        case hal::LinkShape::Kind::Box:
          shape.kind = sim_hal::Shape::Kind::Box;
          break;
        case hal::LinkShape::Kind::Cylinder:
          shape.kind = sim_hal::Shape::Kind::Cylinder;
          break;
        case hal::LinkShape::Kind::Sphere:
          shape.kind = sim_hal::Shape::Kind::Sphere;
          break;
      }
      shape.size = link_shape.size;
      shape.X_WS = X_WL[i] * link_shape.X_LS;
      shape.label = Label::Robot;
      world.shapes.push_back(shape);
    }
}

/// An arm posture drawn from a seed: within the limits, bent towards the room before the base.
inline hal::JointVector random_posture(const hal::RobotModel& model, std::uint64_t seed) {
  sim_hal::Draws draws(seed, 31);
  const hal::JointVector lower = model.lower_rad(), upper = model.upper_rad();
  hal::JointVector q;
  for (int i = 0; i < hal::kArmJoints; ++i) q[i] = draws.between(0.8 * lower[i], 0.8 * upper[i]);
  return q;
}

/// A room with robot, object and partner, and the same without the robot.
struct RobotView {
  hal::RobotModel model = hal::built_in_robot();
  sim_hal::SyntheticScene scene;
  sim_hal::World without, world;
  hal::JointVector q_rad;
  hal::HandPosture hand;
  sim_hal::Rendering truth, background;
  hal::DepthFrame frame;

  explicit RobotView(std::uint64_t seed)
      : scene(sim_hal::make_scene(seed % 2 ? sim_hal::ObjectKind::Table : sim_hal::ObjectKind::Chair, seed)) {
    sim_hal::Draws draws(seed, 32);
    q_rad = random_posture(model, seed);
    hand = hal::coupled_posture(draws.between(0.0, 2.4), draws.between(0.0, 3.1));
    without = sim_hal::with_partner(scene.world, sim_hal::make_partner(scene, seed, seed % 3 == 0));
    // the robot's base stands at the world's origin; so the room is moved until the object is before it
    const double away = draws.between(0.7, 1.1), angle = draws.between(-0.6, 0.6);
    const hal::Vec3 shift = hal::Vec3(away * std::cos(angle), away * std::sin(angle), 0.0) -
                            hal::Vec3(scene.cog.x(), scene.cog.y(), 0.0);
    for (auto& shape : without.shapes) shape.X_WS.translation() += shift;
    scene.X_WC.translation() += shift;
    // from farther away, so that the arm is in view
    scene.X_WC.translation() -= draws.between(0.0, 0.5) * scene.X_WC.linear().col(2);
    world = without;
    add_robot(world, model, q_rad, hand);
    truth = sim_hal::cast_rays(world, scene.intrinsics, scene.X_WC);
    background = sim_hal::cast_rays(without, scene.intrinsics, scene.X_WC);
    frame = sim_hal::measure(truth, {}, seed);
  }

  [[nodiscard]] SelfFilter filter(const SelfFilterConfig& config = {}) const {
    return {model, scene.intrinsics, scene.X_WC, NoiseModel{}, config};
  }

  [[nodiscard]] hal::Vec3 point(std::size_t pixel) const {
    const auto& k = scene.intrinsics;
    const int u = static_cast<int>(pixel) % k.width, v = static_cast<int>(pixel) / k.width;
    const auto z = static_cast<double>(frame.depth_m[pixel]);
    return scene.X_WC * hal::Vec3((u - k.cx) / k.fx * z, (v - k.cy) / k.fy * z, z);
  }

  /// Nearer than anything that the room without the robot shows around this pixel: the robot, or a mixture of
  /// its depth with what is behind it.
  [[nodiscard]] bool shows_robot(std::size_t pixel) const {
    const int width = scene.intrinsics.width, height = scene.intrinsics.height;
    const int u0 = static_cast<int>(pixel) % width, v0 = static_cast<int>(pixel) / width;
    float nearest = std::numeric_limits<float>::infinity();
    bool robot = false;
    for (int v = std::max(0, v0 - 3); v <= std::min(height - 1, v0 + 3); ++v)
      for (int u = std::max(0, u0 - 3); u <= std::min(width - 1, u0 + 3); ++u) {
        const auto i = static_cast<std::size_t>(v * width + u);
        nearest = std::min(nearest, background.depth_m[i]);
        robot = robot || truth.label[i] == Label::Robot;
      }
    return robot && frame.depth_m[pixel] < nearest - 0.04f;
  }
};

}  // namespace colift::perception::test
