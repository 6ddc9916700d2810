#pragma once

#include <ros2_messages.h>

#include <algorithm>

#include "hal/dds/samples.hpp"
#include "hal/drivers/ros2_camera/ros2_image.hpp"

namespace colift::hal::ros2 {

// Received messages as views for the checks. For .cpp files only.

[[nodiscard]] inline Timestamp time_of(const builtin_interfaces_msg_dds__Time_& t) {
  return std::chrono::seconds(t.sec) + std::chrono::nanoseconds(t.nanosec);
}

[[nodiscard]] inline ImageView view_of(const sensor_msgs_msg_dds__Image_& m) {
  ImageView v;
  v.stamp = time_of(m.header.stamp);
  v.frame_id = dds::text_of(m.header.frame_id), v.encoding = dds::text_of(m.encoding);
  v.width = m.width, v.height = m.height, v.step = m.step, v.is_bigendian = m.is_bigendian;
  v.data = {m.data._buffer, m.data._length};
  return v;
}

[[nodiscard]] inline InfoView view_of(const sensor_msgs_msg_dds__CameraInfo_& m) {
  InfoView v;
  v.frame_id = dds::text_of(m.header.frame_id), v.distortion_model = dds::text_of(m.distortion_model);
  v.width = m.width, v.height = m.height;
  v.d = {m.d._buffer, m.d._length};
  std::copy(std::begin(m.k), std::end(m.k), v.k.begin());
  v.binning_x = m.binning_x, v.binning_y = m.binning_y;
  v.roi_x = m.roi.x_offset, v.roi_y = m.roi.y_offset;
  v.roi_width = m.roi.width, v.roi_height = m.roi.height;
  return v;
}

}  // namespace colift::hal::ros2
