#pragma once

#include <dds/dds.h>

#include <string>

namespace colift::ros2 {

/// A message as it stands in a bag of ROS 2: plain CDR (XCDR1), little endian, behind its four bytes of
/// encapsulation. The message has to be one of that type.
[[nodiscard]] std::string to_cdr(const dds_topic_descriptor_t& type, const void* message);

}  // namespace colift::ros2
