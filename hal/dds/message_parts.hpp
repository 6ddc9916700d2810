#pragma once

#include <ros2_messages.h>

#include <algorithm>
#include <iterator>
#include <string_view>

#include "hal/dds/samples.hpp"
#include "hal/types/time.hpp"

// Parts that many messages have. Only .cpp files include this.

namespace colift::hal::dds {

/// Nanoseconds since 1970 as ROS 2 has them: whole seconds, rounded down, and a rest.
[[nodiscard]] inline builtin_interfaces_msg_dds__Time_ ros_time_of(Timestamp at) {
  const auto whole = std::chrono::floor<std::chrono::seconds>(at);
  return {static_cast<std::int32_t>(whole.count()),
          static_cast<std::uint32_t>(std::chrono::nanoseconds(at - whole).count())};
}

inline void set_header(std_msgs_msg_dds__Header_& out, Timestamp at, std::string_view frame) {
  out.stamp = ros_time_of(at);
  set(out.frame_id, frame);
}

/// A pinhole camera without distortion; of a new message.
inline void set_pinhole(sensor_msgs_msg_dds__CameraInfo_& out, double fx, double fy, double cx, double cy) {
  set(out.distortion_model, "plumb_bob");
  resize(out.d, 5);
  const double k[] = {fx, 0, cx, 0, fy, cy, 0, 0, 1}, r[] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  const double p[] = {fx, 0, cx, 0, 0, fy, cy, 0, 0, 0, 1, 0};
  std::copy(std::begin(k), std::end(k), out.k);
  std::copy(std::begin(r), std::end(r), out.r);
  std::copy(std::begin(p), std::end(p), out.p);
}

}  // namespace colift::hal::dds
