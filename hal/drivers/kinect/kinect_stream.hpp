#pragma once

#include <functional>
#include <optional>
#include <string>

#include "hal/drivers/kinect/capture_link/capture_monitor.hpp"
#include "hal/drivers/kinect/capture_link/capture_process.hpp"
#include "hal/drivers/kinect/capture_link/frame_ring.hpp"
#include "hal/drivers/kinect/depth_table.hpp"
#include "hal/drivers/kinect/device_clock.hpp"
#include "hal/drivers/kinect/kinect_facts.hpp"
#include "hal/drivers/kinect/kinect_report.hpp"
#include "hal/drivers/kinect/kinect_source.hpp"
#include "hal/infrared_camera.hpp"

namespace colift::hal::kinect {

/// The capture process and what comes out of it: started, watched, ended and started anew; its images taken
/// out of the ring, checked, and turned into frames. KinectCamera adds the life of a device. One thread.
struct KinectStream {
  /// The clock has to outlive the stream; it is the one of the frames' time stamps.
  KinectStream(KinectConfig c, const Clock& k) : config(std::move(c)), clock(k), watch(config) {}

  KinectConfig config;
  const Clock& clock;
  std::optional<KinectSource> source;  ///< Set before first_frame().
  CaptureMonitor watch;
  std::optional<FrameRing> ring;
  std::optional<CaptureProcess> process;
  CaptureNews news;
  DepthTable table;
  bool infrared = false;  ///< Asked for, of every process that is started.
  std::uint64_t rejected = 0;
  KinectReport report;
  std::string last_error;
  Timestamp frame_at{0};  ///< When the last depth frame was handed out.

  /// Waits for the process's first image, up to config.open_s. Errors: LinkLost (no device), DeviceFault.
  [[nodiscard]] Result<> first_frame();
  /// Everything that is due: the process's words, its deadlines.
  void look_after();
  /// Until the process says or shows something, at most 20 ms.
  void wait(Duration timeout) const;
  void ask_for_infrared() const;

  /// A new depth image of the ring, if there is one that is good; `on_raw` gets it as it came.
  [[nodiscard]] std::optional<DepthFrame> take(const std::function<void(const RawFrame&, Timestamp)>& on_raw);
  /// The same for infrared.
  [[nodiscard]] std::optional<InfraredFrame> take_infrared();

  [[nodiscard]] bool lost() const;
  [[nodiscard]] std::string words_of_loss() const;

 private:
  void start();
  void note_device(const std::string& why);
  void reject(std::string why);
  [[nodiscard]] std::string words_of_end() const;
  [[nodiscard]] bool is_recording() const { return source && source->kind == KinectSource::Kind::Fakenect; }
  [[nodiscard]] Timestamp arrival(const FrameStamp& stamp) const;
  [[nodiscard]] Timestamp exposed(Timestamp measured) const;
  [[nodiscard]] CameraIntrinsics intrinsics() const {
    return {kWidth, kHeight, config.fx, config.fy, config.cx, config.cy};
  }
  [[nodiscard]] DepthFrame convert(const DeviceClock::Times& times);

  SteadyClock machine_;  // that of the capture process
  DeviceClock times_;
  RawFrame raw_, before_, infrared_raw_;
  Timestamp device_at_{Timestamp::min()}, infrared_at_{Timestamp::min()};
};

}  // namespace colift::hal::kinect
