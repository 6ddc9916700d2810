#pragma once

#include <sys/types.h>

#include <cstdint>
#include <optional>
#include <string>

#include "hal/drivers/kinect/depth_table.hpp"

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
  std::string error;       ///< Why it does not stream; empty when it does.
  std::string last_words;  ///< The last line of the library.
};

}  // namespace colift::hal
