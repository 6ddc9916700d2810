#pragma once

#include <optional>

#include "sim_hal/emulator/camera/camera_source.hpp"
#include "sim_hal/mujoco/devices/sim_infrared.hpp"
#include "sim_hal/mujoco/sim_world.hpp"

namespace colift::sim_hal {

/// The scenario's camera in a SimWorld, which somebody else moves; its infrared images show the emitter on
/// the palm. Any thread, one at a time.
class CameraWorldSource final : public CameraSource {
 public:
  explicit CameraWorldSource(const SimWorld& world, const SimEmitter& emitter = {});
  [[nodiscard]] CameraExposure look(std::uint64_t frame) override;
  [[nodiscard]] Vec3 up_C() const override { return up_in(X_WC_); }
  void turn(double angle_rad) override;
  [[nodiscard]] std::vector<std::uint16_t> infrared(const CameraExposure& exposure) override;

 private:
  const SimWorld& world_;
  SimEmitter emitter_;
  Pose X_WC_;
  RayCaster caster_;
  std::optional<SimInfraredSource> infrared_;  ///< Since the first one was wanted.
  std::uint64_t frame_ = 0;
};

}  // namespace colift::sim_hal
