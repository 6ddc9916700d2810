#pragma once

#include <string>
#include <string_view>

#include "hal/types/result.hpp"

namespace colift::telemetry {

// std_msgs/msg/String in CDR, little endian: a text for tools of ROS 2, for Foxglove and Lichtblick.

/// The type of these messages, as it stands in a recording: name, and definition in ROS's language
/// ("ros2msg").
inline constexpr const char* kStringType = "std_msgs/msg/String";
[[nodiscard]] std::string string_definition();

[[nodiscard]] std::string string_message(std::string_view text);
/// The text lies in the message's bytes. Errors: BadInput (cut, or big endian).
[[nodiscard]] hal::Result<std::string_view> parse_string(std::string_view bytes);

}  // namespace colift::telemetry
