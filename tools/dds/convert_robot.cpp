// The robot's model, joints and frames.

#include "tools/dds/convert_parts.hpp"
#include "tools/telemetry/channels/messages.hpp"
#include "tools/telemetry/channels/string_message.hpp"

namespace colift::ros2 {
namespace {

bool is_camera(const Json& transform) {
  return transform.at("child_frame_id").get_ref<const std::string&>() == telemetry::kCameraFrame;
}

bool transforms(tf2_msgs_msg_dds__TFMessage_& out, const ChannelMessage& in, bool camera) {
  const Json all = Json::parse(in.bytes);
  std::size_t count = 0;
  for (const Json& t : all.at("transforms")) count += is_camera(t) == camera;
  auto* to = hal::dds::resize(out.transforms, count);
  for (const Json& t : all.at("transforms")) {
    if (is_camera(t) != camera) continue;
    set_header(to->header, stamp_of(t.at("timestamp")) + in.to_ros,
               t.at("parent_frame_id").get_ref<const std::string&>());
    set_text(to->child_frame_id, t.at("child_frame_id"));
    set_xyz(to->transform.translation, t.at("translation"));
    set_quaternion(to->transform.rotation, t.at("rotation"));
    ++to;
  }
  return count > 0;
}

}  // namespace

bool to_description(std_msgs_msg_dds__String_& out, const ChannelMessage& in) {
  const auto text = telemetry::parse_string(in.bytes);
  if (text) hal::dds::set(out.data, *text);
  return text.has_value();
}

bool to_joint_state(sensor_msgs_msg_dds__JointState_& out, const ChannelMessage& in) {
  const Json all = Json::parse(in.bytes);
  const Json& joints = all.at("joints");
  set_header(out.header, in.at + in.to_ros, "");
  char** names = hal::dds::resize(out.name, joints.size());
  double* positions = hal::dds::resize(out.position, joints.size());
  double* efforts = hal::dds::resize(out.effort, joints.size());
  for (std::size_t i = 0; i < joints.size(); ++i) {
    set_text(names[i], joints[i].at("name"));
    positions[i] = number_of(joints[i].at("position"));
    efforts[i] = joints[i].contains("effort") ? number_of(joints[i]["effort"])
                                              : std::numeric_limits<double>::quiet_NaN();
  }
  return !joints.empty();
}

bool to_transforms(tf2_msgs_msg_dds__TFMessage_& out, const ChannelMessage& in) {
  return transforms(out, in, false);
}

bool to_static_transforms(tf2_msgs_msg_dds__TFMessage_& out, const ChannelMessage& in) {
  return transforms(out, in, true);
}

}  // namespace colift::ros2
