#pragma once

#include <memory>
#include <optional>

#include "hal/config/range.hpp"
#include "hal/depth_camera.hpp"

namespace colift::hal {

/// What a frame needs to pass, and when the camera counts as lost.
struct CameraGuardConfig {
  double silent_s = 0.2;
  double frozen_s = 0.2;
  double min_valid_fraction = 0.02;
  int bad_in_a_row = 5;
  int good_to_return = 30;
  double max_age_s = 0.3;
  double moved_deg = 0.5;
  double mounted_deg = 3.0;

  template <class Visitor>
  void visit(Visitor& v) {
    v("silent_s", silent_s, kPositive, "Without a good frame for this long the camera is lost (s).");
    v("frozen_s", frozen_s, kNotNegative,
      "The same picture to the last bit for this long is a dead camera (s); 0: not looked at.");
    v.renamed("stuck_s", "frozen_s");
    v("min_valid_fraction", min_valid_fraction, kFraction,
      "Min fraction of pixels with depth in a usable frame.");
    v.renamed("least_seen", "min_valid_fraction");
    v("bad_in_a_row", bad_in_a_row, Range{1, 1000}, "So many bad frames in a row and the camera is lost.");
    v("good_to_return", good_to_return, Range{1, 1000},
      "So many good frames in a row and a lost one is back.");
    v("max_age_s", max_age_s, kPositive,
      "Frames that are older than this when they come, in the mean: the camera is lost (s).");
    v.renamed("most_age_s", "max_age_s");
    v("moved_deg", moved_deg, kPositive,
      "A camera whose gravity turns by more than this since the start was moved (deg).");
    v("mounted_deg", mounted_deg, kPositive,
      "The same against the calibrated pose, which the accelerometer knows no better (deg).");
  }
};

/// A DepthCamera around a DepthCamera: a frame passes only when it is whole, in metres, newer than the one
/// before, and shows something; the camera is lost when such frames stay out, come late, or show the same
/// picture to the last bit; and is back after some good frames in a row. A camera that was moved since its
/// calibration gives no frames any more.
class GuardedCamera final : public DepthCamera {
 public:
  /// The clock is that of the frames' time stamps and outlives the guard. `up_C`: against gravity, as the
  /// calibration has it; unset: not known.
  GuardedCamera(std::unique_ptr<DepthCamera> inner, const CameraGuardConfig& config, const Clock& clock,
                std::optional<Vec3> up_C = std::nullopt);
  ~GuardedCamera() override;

  [[nodiscard]] Result<> configure() override;
  [[nodiscard]] Result<> activate() override;
  void deactivate() noexcept override;
  /// What the guard dropped counts as rejected.
  [[nodiscard]] DeviceHealth health() const override;
  /// Errors: Timeout (none within `timeout`, or only bad ones), LinkLost (the camera is lost; frames come
  /// again by themselves where the inner camera's do), DeviceFault (it was moved).
  [[nodiscard]] Result<DepthFrame> next_frame(std::chrono::milliseconds timeout) override;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace colift::hal
