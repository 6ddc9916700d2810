#pragma once

#include "sim_hal/emulator/camera_eye.hpp"
#include "sim_hal/mujoco/sim_world.hpp"

namespace colift::sim_hal {

/// The scenario's camera in a SimWorld, which somebody else moves. Any thread, one at a time.
class CameraWorldEye final : public CameraEye {
 public:
  explicit CameraWorldEye(const SimWorld& world);
  [[nodiscard]] CameraExposure look(std::uint64_t frame) override;
  [[nodiscard]] Vec3 up_C() const override { return up_in(X_WC_); }
  void turn(double angle_rad) override;

 private:
  const SimWorld& world_;
  Pose X_WC_;
  RayCaster caster_;
};

}  // namespace colift::sim_hal
