#pragma once

#include <functional>
#include <optional>
#include <string>

#include "hal/drivers/capture_link/capture_supervisor.hpp"
#include "hal/drivers/kinect/depth_table.hpp"
#include "hal/drivers/kinect/device_clock.hpp"
#include "hal/drivers/kinect/kinect_facts.hpp"
#include "hal/drivers/kinect/kinect_report.hpp"
#include "hal/drivers/kinect/kinect_source.hpp"
#include "hal/infrared_camera.hpp"

namespace colift::hal::kinect {

/// What comes out of the capture process: its images taken out of the ring, checked, and turned into frames.
/// KinectCamera adds what a caller asks for. One thread.
class KinectStream final : public capture::CaptureSupervisor {
 public:
  /// The clock has to outlive the stream; it is the one of the frames' time stamps.
  KinectStream(KinectConfig c, const Clock& k)
      : CaptureSupervisor("kinect", c, {2, static_cast<std::uint32_t>(kInfraredPixels)}, k),
        config(std::move(c)) {}

  /// Finds what the configuration names, once. Errors: BadConfig.
  [[nodiscard]] Result<> find_source();
  void ask_for_infrared() const;
  /// A new infrared image of the ring, if there is one that is good.
  [[nodiscard]] std::optional<InfraredFrame> take_infrared();

  KinectConfig config;
  DepthTable table;
  bool infrared = false;  ///< Asked for, of every process that is started.
  KinectReport report;
  /// Gets every depth image that is handed out, as it came.
  std::function<void(const capture::RawFrame&, Timestamp exposed_at)> on_raw;

 protected:
  [[nodiscard]] std::optional<DepthFrame> take() override;
  void started() override;
  void heard() override;
  [[nodiscard]] bool is_recording() const override {
    return source_ && source_->kind == KinectSource::Kind::Fakenect;
  }

 private:
  [[nodiscard]] bool is_size(const capture::RawFrame& raw, int height);
  [[nodiscard]] Timestamp exposed(Timestamp measured) const;
  [[nodiscard]] CameraIntrinsics intrinsics() const {
    return {kWidth, kHeight, config.fx, config.fy, config.cx, config.cy};
  }
  [[nodiscard]] DepthFrame convert(const DeviceClock::Times& times);

  std::optional<KinectSource> source_;
  DeviceClock times_;
  capture::RawFrame raw_, before_, infrared_raw_;
  Timestamp device_at_{Timestamp::min()}, infrared_at_{Timestamp::min()};
};

}  // namespace colift::hal::kinect
