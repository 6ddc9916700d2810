#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "hal/drivers/capture_link/capture_words.hpp"
#include "hal/drivers/capture_link/frame_ring.hpp"
#include "hal/drivers/kinect/capture/library.hpp"

namespace colift::capture {

using Clock = std::chrono::steady_clock;
using hal::capture::CaptureEnd;

/// How a session ended.
struct End {
  CaptureEnd why = CaptureEnd::BadCall;
  std::string reason;
};

/// One Kinect through libfreenect, from open to the first thing that goes wrong: who wants it again starts
/// the process again. One thread; the library calls back in it.
class Device {
 public:
  Device(hal::capture::FrameRingWriter& ring, std::string serial, bool motor);
  ~Device();
  Device(const Device&) = delete;
  Device& operator=(const Device&) = delete;

  /// Finds, opens, starts the depth.
  [[nodiscard]] std::optional<End> open();
  /// Some milliseconds of the device's events, and what is due besides.
  [[nodiscard]] std::optional<End> turn();

  // Requests; a sentence when they cannot be met.
  [[nodiscard]] std::optional<std::string> want_infrared(bool wanted);
  [[nodiscard]] std::optional<std::string> set_brightness(int brightness);
  [[nodiscard]] std::optional<std::string> tilt(double degrees);

  void close();

 private:
  static void on_depth(freenect_device* device, void* pixels, std::uint32_t ticks);
  static void on_video(freenect_device* device, void* pixels, std::uint32_t ticks);
  static void on_log(freenect_context* context, freenect_loglevel level, const char* text);
  [[nodiscard]] hal::capture::FrameStamp stamp(std::uint32_t ticks, int height) const;
  [[nodiscard]] std::optional<End> watch_frames(Clock::time_point now);
  void read_accelerometer(Clock::time_point now);
  void log(int level, const char* text);

  hal::capture::FrameRingWriter& ring_;
  std::string serial_;
  bool motor_ = false;
  freenect_context* context_ = nullptr;
  freenect_device* device_ = nullptr;
  bool depth_on_ = false, infrared_on_ = false;
  std::vector<std::uint16_t> depth_, infrared_;
  std::uint64_t frames_ = 0, frames_seen_ = 0;
  int errors_in_a_row_ = 0;
  std::uint32_t lost_ = 0;
  Clock::time_point frame_at_{}, restarted_at_{}, accel_at_{};
  hal::capture::FrameStamp motion_;  ///< Of it only accelerometer and tilt.
  std::string last_log_;
};

}  // namespace colift::capture
