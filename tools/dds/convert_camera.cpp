// What the camera saw.

#include <algorithm>
#include <array>

#include "tools/dds/convert_parts.hpp"
#include "tools/telemetry/channels/image_message.hpp"
#include "tools/telemetry/channels/messages.hpp"

namespace colift::ros2 {
namespace {

constexpr std::uint8_t kFloat32 = 7;  // sensor_msgs/PointField

/// RFC 4648; ends at the first character that is none of its own.
std::string from_base64(const std::string& text) {
  static constexpr std::string_view kLetters =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  static const std::array<int, 256> values = [] {
    std::array<int, 256> v{};
    v.fill(-1);
    for (std::size_t i = 0; i < kLetters.size(); ++i)
      v[static_cast<unsigned char>(kLetters[i])] = static_cast<int>(i);
    return v;
  }();
  std::string out;
  out.reserve(text.size() / 4 * 3);
  std::uint32_t bits = 0;
  int have = 0;
  for (const char c : text) {
    const int value = values[static_cast<unsigned char>(c)];
    if (value < 0) break;
    bits = (bits << 6) | static_cast<std::uint32_t>(value);
    have += 6;
    if (have < 8) continue;
    have -= 8;
    out.push_back(static_cast<char>((bits >> have) & 0xff));
  }
  return out;
}

template <class Sequence>
void set_bytes(Sequence& out, std::string_view bytes) {
  std::uint8_t* to = hal::dds::resize(out, bytes.size());
  if (!bytes.empty()) std::memcpy(to, bytes.data(), bytes.size());
}

}  // namespace

bool to_image(sensor_msgs_msg_dds__Image_& out, const ChannelMessage& in) {
  const auto image = telemetry::parse_image(in.bytes);
  if (!image) return false;
  set_header(out.header, image->stamp + in.to_ros, image->frame_id);
  out.height = image->height, out.width = image->width, out.step = image->step;
  hal::dds::set(out.encoding, image->encoding);
  set_bytes(out.data, image->data);
  return true;
}

bool to_camera_info(sensor_msgs_msg_dds__CameraInfo_& out, const ChannelMessage& in) {
  const Json j = Json::parse(in.bytes);
  set_header(out.header, bounded(j.at("exposed_at").get<std::int64_t>(), 1'000'000'000) + in.to_ros,
             telemetry::kCameraFrame);
  out.width = j.at("width").get<std::uint32_t>(), out.height = j.at("height").get<std::uint32_t>();
  const double fx = number_of(j.at("fx")), fy = number_of(j.at("fy"));
  const double cx = number_of(j.at("cx")), cy = number_of(j.at("cy"));
  hal::dds::set_pinhole(out, fx, fy, cx, cy);
  return true;
}

bool to_cloud(sensor_msgs_msg_dds__PointCloud2_& out, const ChannelMessage& in) {
  const Json j = Json::parse(in.bytes);
  set_header(out.header, stamp_of(j.at("timestamp")) + in.to_ros,
             j.at("frame_id").get_ref<const std::string&>());
  const auto stride = j.at("point_stride").get<std::uint32_t>();
  const std::string bytes = from_base64(j.at("data").get_ref<const std::string&>());
  if (stride == 0) return false;
  const Json& fields = j.at("fields");
  auto* to = hal::dds::resize(out.fields, fields.size());
  for (const Json& f : fields) {
    set_text(to->name, f.at("name"));
    to->offset = f.at("offset").get<std::uint32_t>();
    to->datatype = kFloat32;
    to->count = 1;
    ++to;
  }
  out.point_step = stride;
  out.height = 1;
  out.width = static_cast<std::uint32_t>(bytes.size() / stride);
  out.row_step = out.width * stride;
  out.is_dense = true;
  set_bytes(out.data, std::string_view(bytes).substr(0, out.row_step));
  return true;
}

}  // namespace colift::ros2
