#pragma once

#include "sim_hal/emulator/video/video_source.hpp"
#include "sim_hal/mujoco/sim_world.hpp"

namespace colift::sim_hal {

/// A depth camera of any size at the place of the scenario's camera in a SimWorld, which somebody else moves.
/// Any thread, one at a time.
class VideoWorldSource final : public VideoSource {
 public:
  VideoWorldSource(const SimWorld& world, const hal::CameraIntrinsics& camera);
  [[nodiscard]] const hal::CameraIntrinsics& camera() const override { return camera_; }
  [[nodiscard]] std::vector<float> look(std::uint64_t frame) override;

 private:
  const SimWorld& world_;
  hal::CameraIntrinsics camera_;
  RayCaster caster_;
};

}  // namespace colift::sim_hal
