#pragma once

#include <algorithm>
#include <limits>
#include <nlohmann/json.hpp>
#include <string>

#include "hal/dds/message_parts.hpp"
#include "hal/dds/samples.hpp"
#include "tools/dds/convert.hpp"

namespace colift::ros2 {

// Pieces of messages. For .cpp files of this folder only.

using Json = nlohmann::json;

inline double number_of(const Json& j) {
  return j.is_null() ? std::numeric_limits<double>::quiet_NaN() : j.get<double>();
}

/// A time of a recording that may come from anybody: at most a century, so that sums stay in range.
inline hal::Timestamp bounded(std::int64_t count, std::int64_t per_second) {
  constexpr std::int64_t kMost_s = 3'200'000'000;
  const std::int64_t most = kMost_s * per_second;
  return hal::Timestamp(std::clamp(count, -most, most) * (1'000'000'000 / per_second));
}
inline hal::Timestamp stamp_of(const Json& time) {
  return bounded(time.at("sec").get<std::int64_t>(), 1) +
         bounded(time.at("nsec").get<std::int64_t>(), 1'000'000'000);
}

using hal::dds::set_header;

inline void set_text(char*& out, const Json& text) {
  hal::dds::set(out, text.get_ref<const std::string&>());
}

/// {"x", "y", "z"}
template <class Xyz>
void set_xyz(Xyz& out, const Json& j) {
  out.x = number_of(j.at("x")), out.y = number_of(j.at("y")), out.z = number_of(j.at("z"));
}
/// [x, y, z]; null is NaN.
template <class Xyz>
void set_list(Xyz& out, const Json& j) {
  const bool known = j.is_array();
  const auto at = [&](int i) {
    return known ? number_of(j.at(static_cast<std::size_t>(i))) : std::numeric_limits<double>::quiet_NaN();
  };
  out.x = at(0), out.y = at(1), out.z = at(2);
}
template <class Quaternion>
void set_quaternion(Quaternion& out, const Json& j) {
  set_xyz(out, j);
  out.w = number_of(j.at("w"));
}

}  // namespace colift::ros2
