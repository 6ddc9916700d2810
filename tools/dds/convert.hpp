#pragma once

#include <colift_messages.h>
#include <ros2_messages.h>

#include <cstdint>
#include <string>

#include "hal/types/time.hpp"

namespace colift::ros2 {

// Messages of a run's channels as messages of ROS 2. For .cpp files of this folder only. Each fills an empty
// message and says whether it is to be sent; what the channel's JSON lacks throws nlohmann's exception.

/// One message of a channel, encoded.
struct ChannelMessage {
  const std::string& bytes;
  hal::Timestamp at{0};     ///< Of the robot's clock.
  hal::Duration to_ros{0};  ///< Added to the robot's clock: ROS time, nanoseconds since 1970.
};

/// What is no text in CDR is false.
[[nodiscard]] bool to_description(std_msgs_msg_dds__String_& out, const ChannelMessage& in);
[[nodiscard]] bool to_joint_state(sensor_msgs_msg_dds__JointState_& out, const ChannelMessage& in);
/// Links of the robot, or object and partner, each a child of "world" with its own stamp; the camera, which
/// rests, is in to_static_transforms() alone.
[[nodiscard]] bool to_transforms(tf2_msgs_msg_dds__TFMessage_& out, const ChannelMessage& in);
[[nodiscard]] bool to_static_transforms(tf2_msgs_msg_dds__TFMessage_& out, const ChannelMessage& in);

[[nodiscard]] bool to_image(sensor_msgs_msg_dds__Image_& out, const ChannelMessage& in);
/// From Topic::Frame, so that it has the stamp of the image that belongs to it.
[[nodiscard]] bool to_camera_info(sensor_msgs_msg_dds__CameraInfo_& out, const ChannelMessage& in);
[[nodiscard]] bool to_cloud(sensor_msgs_msg_dds__PointCloud2_& out, const ChannelMessage& in);

/// Replaces all markers of the topic. Namespaces are the names of the entities ("candidate 12").
[[nodiscard]] bool to_markers(visualization_msgs_msg_dds__MarkerArray_& out, const ChannelMessage& in);

[[nodiscard]] bool to_task_status(colift_msgs_msg_dds__TaskStatus_& out, const ChannelMessage& in);
[[nodiscard]] bool to_decision(colift_msgs_msg_dds__Decision_& out, const ChannelMessage& in);
[[nodiscard]] bool to_diagnostics(diagnostic_msgs_msg_dds__DiagnosticArray_& out, const ChannelMessage& in);

}  // namespace colift::ros2
