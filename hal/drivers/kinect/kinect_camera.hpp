#pragma once

#include <functional>
#include <memory>
#include <string>

#include "hal/depth_camera.hpp"
#include "hal/drivers/kinect/capture_link/capture_process.hpp"
#include "hal/drivers/kinect/capture_link/frame_ring.hpp"
#include "hal/drivers/kinect/depth_table.hpp"
#include "hal/drivers/kinect/kinect_config.hpp"
#include "hal/infrared_camera.hpp"

namespace colift::hal {

/// What a person wants to know about the Kinect.
struct KinectReport {
  pid_t pid = -1;  ///< Of the capture process; -1 while there is none.
  std::uint64_t starts = 0, kills = 0;
  std::uint64_t frames = 0;   ///< Handed out.
  std::uint64_t missed = 0;   ///< Came and went while nobody asked.
  std::uint64_t suspect = 0;  ///< With lost packets or what they leave.
  std::uint64_t lost_packets = 0;
  std::uint64_t old = 0;     ///< Not newer than the one before.
  std::uint64_t broken = 0;  ///< Not what a frame looks like.
  double rate_hz = 0.0;      ///< Of the device, smoothed.
  double late_ms = 0.0;      ///< Of the last frame, beyond the quickest delivery.
  double seen = 0.0;         ///< Part of the last frame's pixels that have a depth.
  std::string serial;
  kinect::DepthConstants constants;
  bool own_constants = false;  ///< The device's own, not the nominal ones.
  bool infrared = false, motor = false;
  std::optional<double> tilt_deg;
  std::string trouble;     ///< Why it does not stream; empty when it does.
  std::string last_words;  ///< The last line of the library.
};

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
  [[nodiscard]] Result<DepthFrame> next_frame(std::chrono::milliseconds patience) override;

  [[nodiscard]] Result<> want_infrared(bool wanted) override;
  [[nodiscard]] Result<InfraredFrame> next_infrared(std::chrono::milliseconds patience) override;

  /// Moves the camera's foot; whatever was calibrated is wrong afterwards. Errors: LimitExceeded (beyond 31
  /// degrees), NotReady (not open, or without motor).
  [[nodiscard]] Result<> tilt(double degrees);
  /// Of the infrared image, 1 to 50.
  [[nodiscard]] Result<> set_infrared_brightness(int brightness);

  [[nodiscard]] KinectReport report() const;

  /// Called with every depth frame that is handed out, as it came from the device: for recordings.
  std::function<void(const kinect::RawFrame&, Timestamp exposed_at)> on_raw;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace colift::hal
