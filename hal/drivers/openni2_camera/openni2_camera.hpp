#pragma once

#include <sys/types.h>

#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "hal/depth_camera.hpp"
#include "hal/drivers/openni2_camera/depth_frame.hpp"
#include "hal/drivers/openni2_camera/frame_gate.hpp"
#include "hal/drivers/openni2_camera/openni2_config.hpp"

namespace colift::hal {
namespace openni2 {
class Openni2Stream;
}

/// What a person wants to know about an OpenNI2 camera.
struct Openni2Report {
  pid_t pid = -1;  ///< Of the capture process; -1 while there is none.
  std::uint64_t starts = 0, kills = 0;
  std::uint64_t missed = 0;  ///< Came and went while nobody asked.
  std::uint64_t broken = 0;  ///< Not what a frame looks like.
  openni2::FrameGate::Counts dropped;
  double late_ms = 0.0;  ///< Of the last frame, beyond the quickest delivery.
  std::string name, serial;
  std::string error;       ///< Why it does not stream; empty when it does.
  std::string last_words;  ///< The last that was noted: the mode, a frame that was wrong.
};

/// A depth camera behind OpenNI2 (PrimeSense, Xtion, others with their vendor's driver; recordings) as a
/// DepthCamera. OpenNI2 runs in a process of its own, which is watched, killed when it hangs, and started
/// anew with growing pauses; nothing of that blocks the caller. One thread.
///
/// After a LinkLost frames come again by themselves; configure() tells meanwhile how it stands without
/// waiting (but begins a recording anew that has ended).
class Openni2Camera final : public DepthCamera {
 public:
  /// `model` unset: from the field of view that the device reports. The clock has to outlive the camera; it
  /// is the one of the frames' time stamps.
  Openni2Camera(Openni2CameraConfig config, std::optional<openni2::PinholeModel> model, const Clock& clock);
  ~Openni2Camera() override;

  /// The first time waits for a frame, up to `open_s`. Errors: BadConfig (no such source, no capture
  /// process), LinkLost (no device, or it went away), DeviceFault (the device does not open or stream).
  [[nodiscard]] Result<> configure() override;
  [[nodiscard]] Result<> activate() override;
  void deactivate() noexcept override;
  [[nodiscard]] DeviceHealth health() const override;
  [[nodiscard]] Result<DepthFrame> next_frame(std::chrono::milliseconds timeout) override;

  /// Before configure(): what the device gives is recorded by OpenNI2 itself, without loss. A process that is
  /// started anew begins the file anew.
  void record_to(const std::filesystem::path& oni);
  /// Ends the recording and waits until the file is whole. Errors: NotReady (nothing is recorded), Timeout.
  [[nodiscard]] Result<> finish_recording(std::chrono::milliseconds timeout);

  [[nodiscard]] Openni2Report report() const;

 private:
  std::unique_ptr<openni2::Openni2Stream> stream_;
  const Clock& clock_;
};

}  // namespace colift::hal
