#pragma once

#include <string>
#include <utility>

#include "tools/telemetry/channels/json_parts.hpp"
#include "tools/telemetry/channels/messages.hpp"

namespace colift::telemetry {

// Pieces of foxglove.SceneUpdate messages. For .cpp files of this folder only.

struct Colour {
  double r = 0.0, g = 0.0, b = 0.0, a = 1.0;
};
inline Json colour_json(const Colour& c) {
  return {{"r", c.r}, {"g", c.g}, {"b", c.b}, {"a", c.a}};
}

inline hal::Pose pose_of(const hal::Vec3& at, const Eigen::Matrix3d& axes = Eigen::Matrix3d::Identity()) {
  hal::Pose pose = hal::Pose::Identity();
  pose.translation() = at;
  pose.linear() = axes;
  return pose;
}

/// A cube or an ellipsoid: full lengths along its axes.
inline Json solid_json(const hal::Pose& pose, const hal::Vec3& size, const Colour& c) {
  return {{"pose", pose_json(pose)}, {"size", xyz(size)}, {"color", colour_json(c)}};
}
/// Along its z axis.
inline Json cylinder_json(const hal::Pose& pose, double radius, double length, const Colour& c) {
  Json j = solid_json(pose, {2.0 * radius, 2.0 * radius, length}, c);
  j["bottom_scale"] = 1.0;
  j["top_scale"] = 1.0;
  return j;
}
/// From the pose along its x axis; the head takes a quarter of the length and is twice as thick.
inline Json arrow_json(const hal::Pose& pose, double length, double thickness, const Colour& c) {
  return {{"pose", pose_json(pose)},      {"shaft_length", 0.75 * length},    {"shaft_diameter", thickness},
          {"head_length", 0.25 * length}, {"head_diameter", 2.0 * thickness}, {"color", colour_json(c)}};
}

inline Json pair_json(const char* key, std::string value) {
  return {{"key", key}, {"value", std::move(value)}};
}

/// Entities of one message.
class Entities {
 public:
  explicit Entities(hal::Timestamp at) : time_(time_json(at)) {}

  Json& add(const std::string& id, Json metadata = Json::array()) {
    all_.push_back({{"timestamp", time_},
                    {"frame_id", kWorldFrame},
                    {"id", id},
                    {"lifetime", {{"sec", 0}, {"nsec", 0}}},
                    {"frame_locked", false},
                    {"metadata", std::move(metadata)},
                    {"arrows", Json::array()},
                    {"cubes", Json::array()},
                    {"spheres", Json::array()},
                    {"cylinders", Json::array()},
                    {"lines", Json::array()},
                    {"triangles", Json::array()},
                    {"texts", Json::array()},
                    {"models", Json::array()}});
    return all_.back();
  }
  /// The whole message: what is no longer there goes first.
  [[nodiscard]] Json take() {
    Json gone = Json::array({{{"timestamp", time_}, {"type", 1}, {"id", ""}}});
    return {{"deletions", std::move(gone)}, {"entities", std::move(all_)}};
  }

 private:
  Json time_, all_ = Json::array();
};

}  // namespace colift::telemetry
