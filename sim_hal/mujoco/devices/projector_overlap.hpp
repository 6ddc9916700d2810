#pragma once

#include <cstdint>
#include <vector>

#include "hal/depth_camera.hpp"
#include "sim_hal/mujoco/sim_world.hpp"
#include "sim_hal/synthetic/ray_caster.hpp"

namespace colift::sim_hal {

/// What the projectors of other cameras do to one's depth image: where a second pattern of speckle lies on a
/// surface, blots of it are not recognised. Each further projector takes 3.5 % of what it illuminates: six
/// Kinects on one scene lost 16.6 % of their pixels (Maimone and Fuchs, IEEE VR 2012). The blots stay where
/// they are as long as the scene does, but for their edges. Without the additional noise of depths that
/// remain.
class ProjectorOverlap {
 public:
  /// For camera `number` of the world's scenario; cameras with `noise: none` have no projector.
  ProjectorOverlap(const SimWorld& world, std::size_t number);

  /// Takes depths out of a frame of that camera. `frame`: its number, for the blots' edges.
  void apply(hal::DepthFrame& image, std::uint64_t frame);

 private:
  struct Projector {
    Pose X_PW;
    RayCaster caster;
    std::uint64_t number;
  };
  const SimWorld& world_;
  Pose X_WC_ = Pose::Identity();
  std::vector<Projector> others_;
};

}  // namespace colift::sim_hal
