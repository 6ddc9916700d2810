#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "hal/dds/participant.hpp"

namespace colift::ros2 {

/// A topic of a bag.
struct BagTopic {
  std::string name, type;  ///< "/tf", "tf2_msgs/msg/TFMessage".
  hal::dds::Qos qos = hal::dds::Qos::Reliable;
  std::uint64_t messages = 0;
};

/// The quality of service under which a topic was offered, in the form of rosbag2 (Humble): a bag's player
/// offers it again, so that a latched topic stays latched.
[[nodiscard]] std::string offered_qos(hal::dds::Qos qos);

/// metadata.yaml of a bag with one file (rosbag2, version 5 of the format: Humble). Times are nanoseconds
/// since 1970.
[[nodiscard]] std::string bag_metadata(const std::string& file, std::uint64_t start_ns, std::uint64_t end_ns,
                                       const std::vector<BagTopic>& topics);

}  // namespace colift::ros2
