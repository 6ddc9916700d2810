#pragma once

#include <string>
#include <string_view>

#include "hal/types/result.hpp"

namespace colift::hal::dds {

/// The DDS topic of a topic of ROS 2: "rt/joint_states" for "/joint_states". Errors: BadConfig for what is no
/// fully qualified name (a slash, then letters, digits and underscores between single slashes, none beginning
/// with a digit, 200 characters at most).
[[nodiscard]] Result<std::string> dds_topic_name(std::string_view ros_name);

/// The domain that ROS_DOMAIN_ID names; 0 where it is unset or empty. Errors: BadConfig beyond 0 to 101, the
/// range in which all ports lie below the ephemeral ones.
[[nodiscard]] Result<int> domain_of_environment();

/// `domain` itself, or where it is negative that of the environment.
[[nodiscard]] Result<int> domain_or_environment(int domain);

inline constexpr int kMaxDomain = 101;

}  // namespace colift::hal::dds
