#include "hal/dds/ros2_names.hpp"

#include <fmt/format.h>

#include <charconv>
#include <cstdlib>

namespace colift::hal::dds {
namespace {

constexpr std::size_t kLongestName = 200;

bool is_letter(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_';
}
bool is_digit(char c) {
  return c >= '0' && c <= '9';
}

bool is_topic(std::string_view name) {
  if (name.size() < 2 || name.size() > kLongestName || name.front() != '/' || name.back() == '/')
    return false;
  bool begins = false;  // a part of the name
  for (const char c : name) {
    if (c == '/') {
      if (begins) return false;
      begins = true;
    } else if (is_letter(c) || (is_digit(c) && !begins)) {
      begins = false;
    } else {
      return false;
    }
  }
  return true;
}

}  // namespace

Result<std::string> dds_topic_name(std::string_view ros_name) {
  if (!is_topic(ros_name))
    return failure(ErrorCode::BadConfig, "ros2.topic",
                   fmt::format("'{}' is no full name of a topic; expected one like /camera/depth/image_rect",
                               ros_name.substr(0, kLongestName)));
  return "rt" + std::string(ros_name);
}

Result<int> domain_of_environment() {
  const char* text = std::getenv("ROS_DOMAIN_ID");
  if (text == nullptr || *text == '\0') return 0;
  const std::string_view given(text);
  int domain = -1;
  const auto [end, error] = std::from_chars(given.data(), given.data() + given.size(), domain);
  if (error != std::errc() || end != given.data() + given.size() || domain < 0 || domain > kMaxDomain)
    return failure(ErrorCode::BadConfig, "ROS_DOMAIN_ID",
                   fmt::format("'{}' is no domain; expected 0 to {}", given.substr(0, 40), kMaxDomain));
  return domain;
}

Result<int> domain_or_environment(int domain) {
  return domain < 0 ? domain_of_environment() : Result<int>(domain);
}

}  // namespace colift::hal::dds
