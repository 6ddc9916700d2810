#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "hal/config/range.hpp"
#include "hal/depth_camera.hpp"
#include "hal/robot_model/robot_model.hpp"
#include "perception/noise_model.hpp"

namespace colift::perception {

/// Which pixels are the robot's own.
struct SelfFilterConfig {
  double padding_m = 0.015;
  double shadow_padding_px = 2.0;
  double noise_sigma = 2.0;
  int min_neighbours = 2;
  double jump_m = 0.02;

  template <class Visitor>
  void visit(Visitor& v) {
    v("padding_m", padding_m, hal::Range{0, 0.2},
      "Padding of the links, for errors of model and calibration (m).");
    v("shadow_padding_px", shadow_padding_px, hal::Range{0, 20},
      "Width in the image around the robot within which pixels that fit none of their neighbours are its "
      "ragged edge (px).");
    v("noise_sigma", noise_sigma, hal::Range{0, 20},
      "Max distance of the robot's pixels beyond the padding, in standard deviations of the depth noise.");
    v("min_neighbours", min_neighbours, hal::Range{0, 8},
      "Min number of neighbours at its own depth of a pixel beside the robot that is kept.");
    v("jump_m", jump_m, hal::Range{0, 0.5}, "Max depth difference of such neighbours, fixed part (m).");
  }
};

/// Removes the robot's own pixels from depth frames, from its model and joint positions at the time of the
/// frame. A pixel is the robot's when its depth, give or take the noise, lies within a padded link shape on
/// the pixel's ray. All tests are linear or quadratic in inverse depth along image rows, so no point is ever
/// computed. Keeps its buffers from frame to frame: one filter, one thread. Does not allocate after the first
/// frame. A link that reaches round the camera itself is not removed.
class SelfFilter {
 public:
  SelfFilter(const hal::RobotModel& model, const hal::CameraIntrinsics& intrinsics, const hal::Pose& X_WC,
             const NoiseModel& noise, const SelfFilterConfig& config);
  ~SelfFilter();
  SelfFilter(SelfFilter&&) noexcept;
  SelfFilter& operator=(SelfFilter&&) noexcept;

  /// Sets the robot's pixels to NaN, in place. Returns them, ascending; valid until the next call. What
  /// stands before the robot stays (a person's arm), and so does what is seen between its links. A frame of
  /// another size than the intrinsics say is left as it is.
  const std::vector<std::uint32_t>& remove(hal::DepthFrame& frame, const hal::JointVector& q_rad,
                                           const hal::HandPosture& hand);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace colift::perception
