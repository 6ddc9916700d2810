#pragma once

#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>

#include "hal/types/geometry.hpp"
#include "hal/types/time.hpp"

namespace colift::telemetry {

// Pieces of JSON messages. For .cpp files only: JSON stays out of other headers. Numbers are written so that
// they read back to the same bits; what is not finite is null.

using Json = nlohmann::ordered_json;

inline Json number_json(double value) {
  return std::isfinite(value) ? Json(value) : Json(nullptr);
}
inline Json number_json(const std::optional<double>& value) {
  return value ? number_json(*value) : Json(nullptr);
}
inline Json xyz(const hal::Vec3& v) {
  return {{"x", v.x()}, {"y", v.y()}, {"z", v.z()}};
}
inline Json list_of(const hal::Vec3& v) {
  return Json::array({number_json(v.x()), number_json(v.y()), number_json(v.z())});
}
template <class Range>
Json numbers_json(const Range& values) {
  Json all = Json::array();
  for (const double v : values) all.push_back(number_json(v));
  return all;
}
inline Json quaternion_json(const Eigen::Matrix3d& rotation) {
  const Eigen::Quaterniond q(rotation);
  return {{"x", q.x()}, {"y", q.y()}, {"z", q.z()}, {"w", q.w()}};
}
inline Json pose_json(const hal::Pose& pose) {
  return {{"position", xyz(pose.translation())}, {"orientation", quaternion_json(pose.linear())}};
}
inline Json time_json(hal::Timestamp at) {
  const std::int64_t ns = at.count() < 0 ? 0 : at.count();
  return {{"sec", ns / 1'000'000'000}, {"nsec", ns % 1'000'000'000}};
}
/// Texts come from devices and files too: what is no UTF-8 is replaced, never thrown about.
inline std::string dumped(const Json& json) {
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

/// Bytes in base64 (RFC 4648).
[[nodiscard]] std::string base64(std::string_view bytes);

}  // namespace colift::telemetry
