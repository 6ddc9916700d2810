#pragma once

#include "hal/depth_camera.hpp"
#include "hal/drivers/capture_link/frame_ring.hpp"
#include "hal/lens.hpp"

namespace colift::hal::openni2 {

/// A camera as its file has it.
struct PinholeModel {
  CameraIntrinsics intrinsics;
  LensDistortion lens;
};

/// Errors: BadConfig with the figure that cannot be.
[[nodiscard]] Result<> check(const PinholeModel& model);

/// What the device sees (rad).
struct FieldOfView {
  double across_rad = 0.0, down_rad = 0.0;
};

/// Whether a camera may be like that.
[[nodiscard]] bool plausible(const FieldOfView& view);

/// The pinhole model that OpenNI2 has of such a camera: its axis goes through the middle of the image.
[[nodiscard]] CameraIntrinsics intrinsics_of(const FieldOfView& view, int width, int height);

/// Depth in metres along Cz, NaN where there is none or where it lies outside min_m to max_m. Errors:
/// BadReply (a unit that is none of OpenNI2's, a size that is not the model's).
[[nodiscard]] Result<std::vector<float>> depth_of(const capture::RawFrame& raw, const PinholeModel& model,
                                                  double min_m, double max_m);

}  // namespace colift::hal::openni2
