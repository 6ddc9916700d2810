#pragma once

#include <memory>
#include <optional>

#include "hal/drivers/kinect/kinect_config.hpp"
#include "hal/guards/guarded_camera.hpp"
#include "hal/infrared_camera.hpp"

namespace colift::hal {

/// A Kinect behind its guard, and beside the guard the infrared images that the same driver gives: a guard
/// judges depth only.
struct GuardedKinect {
  std::unique_ptr<DepthCamera> camera;
  std::shared_ptr<InfraredCamera> infrared;  ///< Lives no longer than `camera`, which owns the driver.
};

/// The clock outlives both. `up_C`: against gravity, as the calibration has it; unset: not known.
[[nodiscard]] GuardedKinect make_guarded_kinect(const KinectConfig& kinect, const CameraGuardConfig& guard,
                                                const Clock& clock, std::optional<Vec3> up_C = std::nullopt);

}  // namespace colift::hal
