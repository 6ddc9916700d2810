#pragma once

#include <vector>

#include "../self_filter/robot_view.hpp"
#include "perception/bodies/body_finder.hpp"
#include "sim_hal/synthetic/person.hpp"

namespace colift::perception::test {

/// A room with an object before the robot, seen by a camera with a Kinect's noise; the arm moves in it, and
/// whatever a test adds.
class Room {
 public:
  Room(sim_hal::ObjectKind kind, std::uint64_t seed) : scene(sim_hal::make_scene(kind, seed)), seed_(seed) {
    sim_hal::Draws draws(seed, 41);
    const double away = draws.between(0.7, 1.0), angle = draws.between(-0.5, 0.5);
    const hal::Vec3 shift = hal::Vec3(away * std::cos(angle), away * std::sin(angle), 0.0) -
                            hal::Vec3(scene.cog.x(), scene.cog.y(), 0.0);
    for (auto& shape : scene.world.shapes) {
      shape.X_WS.translation() += shift;
      object_at += shape.label == Label::Target ? shape.X_WS.translation() : hal::Vec3::Zero().eval();
      targets += shape.label == Label::Target ? 1 : 0;
    }
    object_at /= targets;
    scene.X_WC.translation() += shift - 0.4 * scene.X_WC.linear().col(2);
    home << 0.0, -0.6, 0.0, -1.9, 0.0, 0.8, 0.0;
    home[0] = angle + (draws.between(0, 1) < 0.5 ? 1.2 : -1.2);
    reach << angle, 0.5, 0.0, -1.3, 0.0, 0.9, 0.4;
    SelfFilterConfig padded;
    padded.padding_m = BodyConfig{}.robot_padding_m;
    filter.emplace_back(model, scene.intrinsics, scene.X_WC, NoiseModel{}, padded);
    take_reference(scene.world);
    const auto truth = sim_hal::cast_rays(scene.world, scene.intrinsics, scene.X_WC);
    for (std::size_t i = 0; i < truth.label.size(); ++i)
      if (truth.label[i] == Label::Target && reference.cloud.seen(i))
        object.push_back(reference.cloud.point(i).cast<float>());
  }

  /// Of a room with other things in it.
  void take_reference(const sim_hal::World& world) {
    std::vector<hal::DepthFrame> frames;
    for (int i = 0; i < 10; ++i) {
      frames.push_back(frame(world, 0.0));
      robot_hid.resize(frames.back().depth_m.size());
      for (const std::uint32_t p : filter[0].remove(frames.back(), home, hand)) robot_hid[p] = 1;
    }
    reference = build_reference(frames, scene.X_WC, NoiseModel{}, {.max_restless = 1.0}).value();
  }

  /// The arm is this part of its motion away from home, 0 to 1.
  [[nodiscard]] hal::JointVector posture(double part) const { return home + part * (reach - home); }

  [[nodiscard]] hal::DepthFrame frame(sim_hal::World world, double part) {
    add_robot(world, model, posture(part), hand);
    const auto truth = sim_hal::cast_rays(world, scene.intrinsics, scene.X_WC);
    return sim_hal::measure(truth, {}, sim_hal::hash(seed_, 43, frames_++));
  }

  /// Bodies of a frame with the arm there.
  const std::vector<Body>& bodies(BodyFinder& finder, hal::DepthFrame image, double part,
                                  const hal::Pose& moved = hal::Pose::Identity()) {
    const auto& robot = filter[0].remove(image, posture(part), hand);
    return finder.find(image, robot, moved);
  }
  [[nodiscard]] BodyFinder finder(const BodyConfig& config = {}) const {
    return {reference, object, robot_hid, NoiseModel{}, config};
  }

  sim_hal::SyntheticScene scene;
  hal::RobotModel model = hal::built_in_robot();
  hal::HandPosture hand = hal::coupled_posture(0.0);
  hal::JointVector home, reach;
  hal::Vec3 object_at = hal::Vec3::Zero();
  int targets = 0;
  std::vector<SelfFilter> filter;
  std::vector<char> robot_hid;
  ReferenceImage reference;
  std::vector<Eigen::Vector3f> object;

 private:
  std::uint64_t seed_, frames_ = 0;
};

}  // namespace colift::perception::test
