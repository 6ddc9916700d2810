#pragma once

#include <string>
#include <string_view>

#include "hal/types/result.hpp"

namespace colift::ros2 {

/// "sensor_msgs::msg::dds_::Image_", as DDS calls a type, by its name in ROS 2: "sensor_msgs/msg/Image". What
/// is no such name comes back as it is.
[[nodiscard]] std::string ros2_type(std::string_view dds_type);

/// The definition of a message as bags carry it (MCAP: schema encoding "ros2msg"): its members, then each
/// type that it is made of behind a line of "=" and "MSG: package/Type". Made from the IDL that the program
/// itself is built from, so both have the same members. Errors: NotFound (no such type).
[[nodiscard]] hal::Result<std::string> message_definition(const std::string& ros2_type);

/// The same from the text of an IDL: modules, structs, typedefs of arrays, sequences; comments and
/// annotations are skipped. Errors: BadInput with what was found, NotFound.
[[nodiscard]] hal::Result<std::string> message_definition(std::string_view idl, const std::string& ros2_type);

}  // namespace colift::ros2
