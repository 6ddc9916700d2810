// Messages with a camera's pictures in them.

#include <algorithm>
#include <bit>

#include "tools/telemetry/channels/json_parts.hpp"
#include "tools/telemetry/channels/messages.hpp"
#include "tools/telemetry/mcap/byte_io.hpp"

namespace colift::telemetry {
namespace {

constexpr int kPreviewStep = 2, kCloudStep = 4;
constexpr int kFloat32 = 7;  // foxglove.NumericType

/// A frame of the wrong size shows nothing.
bool usable(const hal::DepthFrame& f) {
  return f.intrinsics.width > 0 && f.intrinsics.height > 0 &&
         f.depth_m.size() ==
             static_cast<std::size_t>(f.intrinsics.width) * static_cast<std::size_t>(f.intrinsics.height);
}

float depth_at(const hal::DepthFrame& f, int u, int v) {
  return f.depth_m[static_cast<std::size_t>(v) * static_cast<std::size_t>(f.intrinsics.width) +
                   static_cast<std::size_t>(u)];
}

}  // namespace

std::string calibration_message(hal::Timestamp at, const hal::CameraIntrinsics& c) {
  return dumped({{"timestamp", time_json(at)},
                 {"frame_id", kCameraFrame},
                 {"width", c.width},
                 {"height", c.height},
                 {"distortion_model", ""},
                 {"D", Json::array()},
                 {"K", {c.fx, 0.0, c.cx, 0.0, c.fy, c.cy, 0.0, 0.0, 1.0}},
                 {"R", {1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0}},
                 {"P", {c.fx, 0.0, c.cx, 0.0, 0.0, c.fy, c.cy, 0.0, 0.0, 0.0, 1.0, 0.0}}});
}

std::string preview_message(const hal::DepthFrame& f) {
  std::string bytes;
  ByteWriter w(bytes);
  int width = 0, height = 0;
  if (usable(f)) {
    width = (f.intrinsics.width + kPreviewStep - 1) / kPreviewStep;
    height = (f.intrinsics.height + kPreviewStep - 1) / kPreviewStep;
    for (int v = 0; v < f.intrinsics.height; v += kPreviewStep)
      for (int u = 0; u < f.intrinsics.width; u += kPreviewStep) {
        const float d = depth_at(f, u, v);
        w.u16(d > 0.0f ? static_cast<std::uint16_t>(std::min(1000.0f * d + 0.5f, 65535.0f))
                       : std::uint16_t{0});
      }
  }
  return dumped({{"timestamp", time_json(f.exposed_at)},
                 {"frame_id", kCameraFrame},
                 {"width", width},
                 {"height", height},
                 {"encoding", "16UC1"},
                 {"step", 2 * width},
                 {"data", base64(bytes)}});
}

std::string cloud_message(const hal::DepthFrame& f) {
  std::string bytes;
  ByteWriter w(bytes);
  const auto put = [&](double value) { w.u32(std::bit_cast<std::uint32_t>(static_cast<float>(value))); };
  if (usable(f)) {
    const hal::CameraIntrinsics& c = f.intrinsics;
    for (int v = 0; v < c.height; v += kCloudStep)
      for (int u = 0; u < c.width; u += kCloudStep) {
        const double d = depth_at(f, u, v);
        if (!(d > 0.0)) continue;
        put((u - c.cx) / c.fx * d), put((v - c.cy) / c.fy * d), put(d);
      }
  }
  Json fields = Json::array();
  int offset = 0;
  for (const char* name : {"x", "y", "z"}) {
    fields.push_back({{"name", name}, {"offset", offset}, {"type", kFloat32}});
    offset += 4;
  }
  return dumped({{"timestamp", time_json(f.exposed_at)},
                 {"frame_id", kCameraFrame},
                 {"pose", pose_json(hal::Pose::Identity())},
                 {"point_stride", offset},
                 {"fields", std::move(fields)},
                 {"data", base64(bytes)}});
}

}  // namespace colift::telemetry
