#pragma once

#include <memory>

#include "hal/arm.hpp"
#include "hal/depth_camera.hpp"
#include "hal/hand.hpp"
#include "hal/robot_model/robot_model.hpp"
#include "sim_hal/imperfect/rig_errors.hpp"

namespace colift::sim_hal {

// Each device stands before a simulated one and makes its values wrong as they leave the simulation.

/// Torque bias, play and noise, and a tool of another mass than the controller believes. Bias and tool act
/// on the arm as well: the controller holds what it believes. `model` outlives the arm.
[[nodiscard]] std::unique_ptr<hal::Arm> make_imperfect_arm(std::unique_ptr<hal::Arm> inner,
                                                           const hal::RobotModel& model,
                                                           const ArmErrors& errors);

/// Focal length, distortion, depth scale and time of exposure. The pose is not the camera's to say: who
/// calibrates uses CameraErrors::X_CK.
[[nodiscard]] std::unique_ptr<hal::DepthCamera> make_imperfect_camera(std::unique_ptr<hal::DepthCamera> inner,
                                                                      const CameraErrors& errors);

/// Drift of strain gauges and tactile pads since the first state.
[[nodiscard]] std::unique_ptr<hal::Hand> make_imperfect_hand(std::unique_ptr<hal::Hand> inner,
                                                             const HandErrors& errors);

}  // namespace colift::sim_hal
