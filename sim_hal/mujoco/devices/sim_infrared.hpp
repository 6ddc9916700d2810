#pragma once

#include <memory>

#include "hal/infrared_camera.hpp"
#include "sim_hal/mujoco/sim_world.hpp"
#include "sim_hal/synthetic/ray_caster.hpp"

namespace colift::sim_hal {

/// The emitter on the simulated palm, and what is not as the model says.
struct SimEmitter {
  Vec3 at_H = {0.020, -0.015, 0.012};  ///< Where it truly is.
  double blink_s = 0.1;                ///< As long lit as dark.
  double arm_m = 0.001;  ///< Error of the arm's absolute position, per axis: smooth over the joints (m).
  double spot_px = 0.3;  ///< Displacement of the spot in the images of a pose, per axis (px).
};

/// What a Kinect's infrared lens sees of a SimWorld, with the blinking emitter in it: behind the simulated
/// camera and the emulated one. Any thread, one at a time; the world has to outlive it.
class SimInfraredSource {
 public:
  /// At the scenario's camera.
  SimInfraredSource(const SimWorld& world, const SimEmitter& emitter);
  void move_to(const Pose& X_WC);
  /// The world as it is now. `frame` seeds the noise.
  [[nodiscard]] hal::InfraredFrame expose(std::uint64_t frame);

 private:
  const SimWorld& world_;
  SimEmitter emitter_;
  RayCaster caster_;
  Eigen::Matrix<double, 3, hal::kArmJoints> wave_;
  Vec3 phase_ = Vec3::Zero();
};

/// The infrared side of the simulated camera. Frames come at 30 Hz; whoever waits for one moves the world.
/// Does not need to be opened. One thread; the world has to outlive it.
[[nodiscard]] std::unique_ptr<hal::InfraredCamera> make_sim_infrared(SimWorld& world,
                                                                     const SimEmitter& emitter);

}  // namespace colift::sim_hal
