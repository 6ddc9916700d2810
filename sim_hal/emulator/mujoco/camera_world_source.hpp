#pragma once

#include <optional>

#include "sim_hal/emulator/camera/camera_source.hpp"
#include "sim_hal/mujoco/devices/projector_overlap.hpp"
#include "sim_hal/mujoco/devices/sim_infrared.hpp"
#include "sim_hal/mujoco/sim_world.hpp"

namespace colift::sim_hal {

/// A camera of the scenario in a SimWorld, which somebody else moves; its infrared images show the emitter on
/// the palm. Any thread, one at a time.
class CameraWorldSource final : public CameraSource {
 public:
  /// `number`: 0 is the first camera, 1 the first of more_cameras.
  explicit CameraWorldSource(const SimWorld& world, std::size_t number = 0, const SimEmitter& emitter = {});
  [[nodiscard]] CameraExposure look(std::uint64_t frame) override;
  [[nodiscard]] Vec3 up_C() const override { return up_in(X_WC_); }
  void turn(double angle_rad) override;
  [[nodiscard]] std::vector<std::uint16_t> infrared(const CameraExposure& exposure) override;

 private:
  const SimWorld& world_;
  ScenarioCamera place_;
  std::uint64_t noise_stream_;
  SimEmitter emitter_;
  Pose X_WC_;
  RayCaster caster_;
  ProjectorOverlap overlap_;
  std::optional<SimInfraredSource> infrared_;  ///< Since the first one was wanted.
  std::uint64_t frame_ = 0;
};

}  // namespace colift::sim_hal
