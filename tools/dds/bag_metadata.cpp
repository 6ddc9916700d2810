#include "tools/dds/bag_metadata.hpp"

#include <fmt/format.h>

namespace colift::ros2 {
namespace {

using hal::dds::Qos;

// rmw's numbers
constexpr int kKeepLast = 1, kReliable = 1, kBestEffort = 2, kTransientLocal = 1, kVolatile = 2;
constexpr const char* kForever = "sec: 9223372036, nsec: 854775807";

/// A text in double quotes as YAML reads it back.
std::string quoted(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') out += '\\';
    if (c == '\n')
      out += "\\n";
    else
      out += c;
  }
  return out + '"';
}

}  // namespace

std::string offered_qos(Qos qos) {
  const hal::dds::QosPolicy policy = hal::dds::policy_of(qos);
  return fmt::format(
      "- history: {}\n  depth: {}\n  reliability: {}\n  durability: {}\n  deadline: {{{}}}\n  lifespan: "
      "{{{}}}\n"
      "  liveliness: 1\n  liveliness_lease_duration: {{{}}}\n  avoid_ros_namespace_conventions: false",
      kKeepLast, policy.depth, policy.reliable ? kReliable : kBestEffort,
      policy.transient_local ? kTransientLocal : kVolatile, kForever, kForever, kForever);
}

std::string bag_metadata(const std::string& file, std::uint64_t start_ns, std::uint64_t end_ns,
                         const std::vector<BagTopic>& topics) {
  std::uint64_t messages = 0;
  std::string list;
  for (const BagTopic& t : topics) {
    messages += t.messages;
    list += fmt::format(
        "    - topic_metadata:\n        name: {}\n        type: {}\n        serialization_format: cdr\n"
        "        offered_qos_profiles: {}\n      message_count: {}\n",
        t.name, t.type, quoted(offered_qos(t.qos)), t.messages);
  }
  return fmt::format(
      "rosbag2_bagfile_information:\n  version: 5\n  storage_identifier: mcap\n  duration:\n    nanoseconds: "
      "{}\n"
      "  starting_time:\n    nanoseconds_since_epoch: {}\n  message_count: {}\n  "
      "topics_with_message_count:\n{}"
      "  compression_format: \"\"\n  compression_mode: \"\"\n  relative_file_paths:\n    - {}\n"
      "  files:\n    - path: {}\n      starting_time:\n        nanoseconds_since_epoch: {}\n      duration:\n"
      "        nanoseconds: {}\n      message_count: {}\n",
      end_ns - start_ns, start_ns, messages, list, file, file, start_ns, end_ns - start_ns, messages);
}

}  // namespace colift::ros2
