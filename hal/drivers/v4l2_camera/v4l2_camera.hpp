#pragma once

#include <memory>

#include "hal/depth_camera.hpp"
#include "hal/drivers/v4l2_camera/v4l2_camera_config.hpp"
#include "hal/drivers/v4l2_camera/z16_image.hpp"
#include "hal/video_calls.hpp"

namespace colift::hal {

/// A depth camera that the kernel serves as a video device of format Z16 (RealSense D4xx and others over
/// uvcvideo). A thread of its own makes every call on the device, because some block for seconds; it opens
/// the device anew when it was lost or stays without a good frame, without end.
///
/// Everything that comes is checked (video_stream.hpp, z16_image.hpp); what is wrong is dropped, counted and
/// described in health(). The device streams from configure() on; frames of before activate() are not given.
class V4l2Camera final : public DepthCamera {
 public:
  /// `clock` is the machine's monotonic one, of which the kernel's stamps are too, and outlives the camera.
  V4l2Camera(V4l2CameraConfig config, const v4l2::DepthModel& model, std::shared_ptr<VideoCalls> calls,
             const Clock& clock);
  /// A call that does not come back within a second is left to its thread, which ends when it does.
  ~V4l2Camera() override;

  /// The first time waits for a frame, up to `open_s`. Errors: BadConfig (the model; a device that cannot do
  /// it), LinkLost (no device), DeviceFault (it refuses, or what comes cannot be used).
  [[nodiscard]] Result<> configure() override;
  [[nodiscard]] Result<> activate() override;
  void deactivate() noexcept override;
  [[nodiscard]] DeviceHealth health() const override;
  [[nodiscard]] Result<DepthFrame> next_frame(std::chrono::milliseconds timeout) override;

 private:
  struct Shared;
  std::shared_ptr<Shared> shared_;
  bool opened_ = false, active_ = false;
  std::uint64_t accepted_ = 0;
  Timestamp since_{0};  ///< Of the first configure() or activate(): silence counts from here at the earliest.

  void start();
  void stop();
  [[nodiscard]] bool silent() const;
  [[nodiscard]] std::string words_of_loss() const;
};

}  // namespace colift::hal
