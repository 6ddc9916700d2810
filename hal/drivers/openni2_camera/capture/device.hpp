#pragma once

#include <OniCAPI.h>

#include <atomic>
#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "hal/drivers/capture_link/capture_words.hpp"
#include "hal/drivers/capture_link/frame_ring.hpp"
#include "hal/drivers/openni2_camera/depth_image.hpp"

namespace colift::capture {

/// What is opened, and how.
struct DeviceRequest {
  std::string uri;     ///< Empty: the first device.
  std::string file;    ///< A recording (.oni); empty: none.
  std::string record;  ///< Where the stream is recorded; empty: nowhere.
  hal::openni2::WantedMode mode;
};

/// How a session ended.
struct End {
  hal::capture::CaptureEnd why = hal::capture::CaptureEnd::BadCall;
  std::string reason;
};

/// One depth camera through OpenNI2, from open to the first thing that goes wrong: who wants it again starts
/// the process again. One thread; OpenNI2 calls back in others, which set flags alone.
class Device {
 public:
  Device(hal::capture::FrameRingWriter& ring, DeviceRequest request);
  ~Device();
  Device(const Device&) = delete;
  Device& operator=(const Device&) = delete;

  /// Finds, opens, starts the depth.
  [[nodiscard]] std::optional<End> open();
  /// Some milliseconds of the device's frames, and what is due besides.
  [[nodiscard]] std::optional<End> turn();
  /// Ends the recording, which is whole then.
  void finish_recording();
  void close();

 private:
  using Clock = std::chrono::steady_clock;
  [[nodiscard]] std::optional<End> open_device();
  [[nodiscard]] std::optional<End> set_mode();
  [[nodiscard]] std::optional<End> as_seen();
  [[nodiscard]] std::optional<End> start();
  void describe() const;
  void take(const OniFrame& frame);
  [[nodiscard]] std::optional<End> look_for_frames() const;
  [[nodiscard]] bool recorded() const { return !request_.file.empty(); }
  static void on_gone(const OniDeviceInfo* info, void* self);
  static void on_state(const OniDeviceInfo* info, OniDeviceState state, void* self);

  hal::capture::FrameRingWriter& ring_;
  DeviceRequest request_;
  bool initialised_ = false, mirrored_ = false;
  OniDeviceHandle device_ = nullptr;
  OniStreamHandle stream_ = nullptr;
  OniRecorderHandle recorder_ = nullptr;
  OniCallbackHandle callbacks_ = nullptr;
  std::string opened_uri_;
  hal::openni2::DepthMode mode_;
  std::vector<std::uint16_t> pixels_;
  std::uint64_t frames_ = 0;
  int last_index_ = 0, last_of_file_ = 0;
  std::string complaint_;
  Clock::time_point frame_at_{};
  std::atomic<bool> gone_{false};
};

}  // namespace colift::capture
