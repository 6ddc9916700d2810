#pragma once

#include <functional>
#include <memory>
#include <string>

#include "hal/depth_camera.hpp"
#include "hal/drivers/capture_link/frame_ring.hpp"
#include "hal/drivers/kinect/kinect_config.hpp"
#include "hal/drivers/kinect/kinect_report.hpp"
#include "hal/infrared_camera.hpp"

namespace colift::hal {
namespace kinect {
class KinectStream;
}

/// A Kinect v1 as a DepthCamera. libfreenect runs in a process of its own, which is watched, killed when it
/// hangs, and started anew with growing pauses; nothing of that blocks the caller. One thread.
///
/// After a LinkLost frames come again by themselves; configure() tells meanwhile how it stands without
/// waiting (but begins a recording anew that has ended).
class KinectCamera final : public DepthCamera, public InfraredCamera {
 public:
  /// The clock has to outlive the camera; it is the one of the frames' time stamps.
  KinectCamera(KinectConfig config, const Clock& clock);
  ~KinectCamera() override;

  /// The first time waits for a frame, up to `open_s`. Errors: BadConfig (no such source, no capture
  /// process), LinkLost (no device, or it went away), DeviceFault (the device does not open or stream).
  [[nodiscard]] Result<> configure() override;
  [[nodiscard]] Result<> activate() override;
  void deactivate() noexcept override;
  [[nodiscard]] DeviceHealth health() const override;
  [[nodiscard]] Result<DepthFrame> next_frame(std::chrono::milliseconds timeout) override;

  [[nodiscard]] Result<> want_infrared(bool wanted) override;
  [[nodiscard]] Result<InfraredFrame> next_infrared(std::chrono::milliseconds timeout) override;

  /// Moves the camera's foot; whatever was calibrated is wrong afterwards. Errors: LimitExceeded (beyond 31
  /// degrees), NotReady (not open, or without motor).
  [[nodiscard]] Result<> tilt(double degrees);
  /// Of the infrared image, 1 to 50.
  [[nodiscard]] Result<> set_infrared_brightness(int brightness);

  [[nodiscard]] KinectReport report() const;

  /// Is called with every depth frame that is handed out, as it came from the device: for recordings.
  void on_raw(std::function<void(const capture::RawFrame&, Timestamp exposed_at)> call);

 private:
  std::unique_ptr<kinect::KinectStream> stream_;
  const Clock& clock_;
};

}  // namespace colift::hal
