#pragma once

#include <cmath>

#include "hal/depth_camera.hpp"
#include "tests/dds/ros_messages.hpp"

namespace colift::tests {

/// A depth frame as a driver of ROS 2 sends it: whole millimetres, 0 where there is none.
inline RosImage image_of_frame(const hal::DepthFrame& f) {
  RosImage m;
  m.header = {system_stamp(), "camera"};
  m.width = static_cast<std::uint32_t>(f.intrinsics.width),
  m.height = static_cast<std::uint32_t>(f.intrinsics.height);
  m.encoding = "16UC1", m.step = 2 * m.width;
  for (const float d : f.depth_m) {
    const auto mm = static_cast<unsigned>(std::isnan(d) ? 0 : std::lround(1000.0 * static_cast<double>(d)));
    m.data.push_back(static_cast<std::uint8_t>(mm & 0xff));
    m.data.push_back(static_cast<std::uint8_t>(mm >> 8));
  }
  return m;
}
inline RosCameraInfo info_of_frame(const hal::DepthFrame& f) {
  RosCameraInfo m;
  const auto& c = f.intrinsics;
  m.header = {system_stamp(), "camera"};
  m.width = static_cast<std::uint32_t>(c.width), m.height = static_cast<std::uint32_t>(c.height);
  m.distortion_model = "plumb_bob", m.d = {0, 0, 0, 0, 0};
  m.k = {c.fx, 0, c.cx, 0, c.fy, c.cy, 0, 0, 1};
  return m;
}

}  // namespace colift::tests
