#include "tools/dds/outlets.hpp"

#include <algorithm>
#include <string_view>

#include "tools/dds/convert_parts.hpp"

namespace colift::ros2 {
namespace {

using hal::dds::Qos;
using telemetry::Topic;

template <class T>
Outlet outlet(Topic channel, const char* topic, Qos qos, const dds_topic_descriptor_t& type,
              bool (*fill)(T&, const ChannelMessage&)) {
  return {channel, topic, qos, &type,
          [fill, &type](const ChannelMessage& in, const std::function<void(const void*)>& take) {
            hal::dds::Sample<T> message(type);
            if (!fill(*message, in)) return false;
            take(&*message);
            return true;
          }};
}

}  // namespace

std::vector<Outlet> outlets() {
  return {
      outlet(Topic::Description, "/robot_description", Qos::Latched, std_msgs_msg_dds__String__desc,
             to_description),
      outlet(Topic::Joints, "/joint_states", Qos::Reliable, sensor_msgs_msg_dds__JointState__desc,
             to_joint_state),
      outlet(Topic::Transforms, "/tf", Qos::Reliable, tf2_msgs_msg_dds__TFMessage__desc, to_transforms),
      outlet(Topic::Tracked, "/tf", Qos::Reliable, tf2_msgs_msg_dds__TFMessage__desc, to_transforms),
      outlet(Topic::Transforms, "/tf_static", Qos::Latched, tf2_msgs_msg_dds__TFMessage__desc,
             to_static_transforms),
      outlet(Topic::Frame, "/colift/depth/camera_info", Qos::Frames, sensor_msgs_msg_dds__CameraInfo__desc,
             to_camera_info),
      outlet(Topic::Depth, "/colift/depth/image_raw", Qos::Frames, sensor_msgs_msg_dds__Image__desc,
             to_image),
      outlet(Topic::Cloud, "/colift/cloud", Qos::Frames, sensor_msgs_msg_dds__PointCloud2__desc, to_cloud),
      outlet(Topic::Scene, "/colift/scene", Qos::Latched, visualization_msgs_msg_dds__MarkerArray__desc,
             to_markers),
      outlet(Topic::Map, "/colift/map", Qos::Latched, visualization_msgs_msg_dds__MarkerArray__desc,
             to_markers),
      outlet(Topic::Bodies, "/colift/bodies", Qos::Reliable, visualization_msgs_msg_dds__MarkerArray__desc,
             to_markers),
      outlet(Topic::Status, "/colift/task_status", Qos::Reliable, colift_msgs_msg_dds__TaskStatus__desc,
             to_task_status),
      outlet(Topic::Decision, "/colift/decision", Qos::Latched, colift_msgs_msg_dds__Decision__desc,
             to_decision),
      outlet(Topic::Devices, "/diagnostics", Qos::Reliable, diagnostic_msgs_msg_dds__DiagnosticArray__desc,
             to_diagnostics),
  };
}

std::size_t first_of_topic(const std::vector<Outlet>& all, std::size_t outlet) {
  const std::string_view topic = all[outlet].topic;
  return static_cast<std::size_t>(
      std::find_if(all.begin(), all.end(), [&](const Outlet& o) { return topic == o.topic; }) - all.begin());
}

bool CameraTransform::repeats(const std::string& bytes) {
  const Json all = Json::parse(bytes);
  const Json& transforms = all.at("transforms");
  if (!transforms.is_array() || transforms.empty()) return true;
  Json camera = transforms.back();
  if (camera.is_object()) camera.erase("timestamp");
  const std::string at = camera.dump();
  if (at == last_) return true;
  last_ = at;
  return false;
}

}  // namespace colift::ros2
