// Scene entities as markers.

#include "tools/dds/convert_parts.hpp"

namespace colift::ros2 {
namespace {

using Marker = visualization_msgs_msg_dds__Marker_;

// visualization_msgs/Marker
constexpr std::int32_t kArrow = 0, kCube = 1, kSphere = 2, kCylinder = 3, kLineStrip = 4, kText = 9;
constexpr std::int32_t kAdd = 0, kDeleteAll = 3;
constexpr double kTextHeight_m = 0.05, kLineWidth_m = 0.005;

struct Kind {
  const char* key;
  std::int32_t type;
};
constexpr Kind kKinds[] = {{"arrows", kArrow},       {"cubes", kCube},      {"spheres", kSphere},
                           {"cylinders", kCylinder}, {"lines", kLineStrip}, {"texts", kText}};

void set_colour(std_msgs_msg_dds__ColorRGBA_& out, const Json& j) {
  out.r = j.at("r").get<float>(), out.g = j.at("g").get<float>();
  out.b = j.at("b").get<float>(), out.a = j.at("a").get<float>();
}

void set_scale(Marker& m, double x, double y, double z) {
  m.scale.x = x, m.scale.y = y, m.scale.z = z;
}

void set_primitive(Marker& m, const Json& p) {
  set_xyz(m.pose.position, p.at("pose").at("position"));
  set_quaternion(m.pose.orientation, p.at("pose").at("orientation"));
  set_colour(m.color, p.at("color"));
  switch (m.type) {
    case kArrow:
      set_scale(m, number_of(p.at("shaft_length")) + number_of(p.at("head_length")),
                number_of(p.at("shaft_diameter")), number_of(p.at("head_diameter")));
      break;
    case kLineStrip: {
      set_scale(m, kLineWidth_m, 0, 0);
      auto* to = hal::dds::resize(m.points, p.at("points").size());
      for (const Json& point : p.at("points")) set_xyz(*to++, point);
      break;
    }
    case kText:
      set_scale(m, 0, 0, kTextHeight_m);
      set_text(m.text, p.at("text"));
      break;
    default:
      set_xyz(m.scale, p.at("size"));
  }
}

}  // namespace

bool to_markers(visualization_msgs_msg_dds__MarkerArray_& out, const ChannelMessage& in) {
  const Json all = Json::parse(in.bytes);
  std::size_t count = 1;
  for (const Json& entity : all.at("entities"))
    for (const Kind& kind : kKinds) count += entity.at(kind.key).size();
  Marker* to = hal::dds::resize(out.markers, count);
  set_header(to->header, in.at + in.to_ros, "world");
  to->action = kDeleteAll;
  to->pose.orientation.w = 1.0;
  ++to;
  for (const Json& entity : all.at("entities")) {
    std::int32_t id = 0;
    for (const Kind& kind : kKinds)
      for (const Json& primitive : entity.at(kind.key)) {
        set_header(to->header, in.at + in.to_ros, entity.at("frame_id").get_ref<const std::string&>());
        set_text(to->ns, entity.at("id"));
        to->id = id++;
        to->type = kind.type;
        to->action = kAdd;
        set_primitive(*to, primitive);
        ++to;
      }
  }
  return true;
}

}  // namespace colift::ros2
