#pragma once

#include <optional>
#include <string>

#include "hal/drivers/capture_link/capture_supervisor.hpp"
#include "hal/drivers/openni2_camera/frame_gate.hpp"
#include "hal/drivers/openni2_camera/openni2_camera.hpp"
#include "hal/drivers/openni2_camera/openni2_source.hpp"

namespace colift::hal::openni2 {

/// What comes out of the capture process: its images taken out of the ring, checked, and turned into frames.
/// One thread.
class Openni2Stream final : public capture::CaptureSupervisor {
 public:
  /// The clock has to outlive the stream; it is the one of the frames' time stamps.
  Openni2Stream(Openni2CameraConfig config, std::optional<PinholeModel> model, const Clock& clock);

  /// Finds what the configuration names, once. Errors: BadConfig.
  [[nodiscard]] Result<> find();
  [[nodiscard]] Openni2Report report() const;

  std::string record_to;  ///< Empty: nothing is recorded.

 protected:
  [[nodiscard]] std::optional<DepthFrame> take() override;
  void started() override;
  void heard() override;
  [[nodiscard]] bool is_recording() const override { return source_ && source_->kind == Source::Kind::File; }

 private:
  Openni2CameraConfig config_;
  std::optional<PinholeModel> model_;  ///< Of the file.
  std::optional<FieldOfView> view_;    ///< As the device says it.
  std::optional<Source> source_;
  FrameGate gate_;
  capture::RawFrame raw_;
  std::uint64_t number_ = 0;  ///< Of the raw frame before.
  double late_ms_ = 0.0;
};

}  // namespace colift::hal::openni2
