#pragma once

#include <functional>
#include <string>
#include <vector>

#include "hal/dds/participant.hpp"
#include "tools/dds/convert.hpp"
#include "tools/telemetry/channels/channels.hpp"

namespace colift::ros2 {

// Which channel of a run is which topic of ROS 2. For .cpp files of this folder only.

struct Outlet {
  telemetry::Topic channel;
  const char* topic;
  hal::dds::Qos qos;
  const dds_topic_descriptor_t* type;
  /// Builds the message of ROS 2 and hands it to `take`; false: there is nothing to say. What the channel's
  /// JSON lacks throws nlohmann's exception.
  std::function<bool(const ChannelMessage&, const std::function<void(const void*)>& take)> convert;
};

/// Outlets of one topic stand for one writer: their types and qualities of service are the same.
[[nodiscard]] std::vector<Outlet> outlets();
/// The first outlet with this one's topic, as an index; its own where it is the first.
[[nodiscard]] std::size_t first_of_topic(const std::vector<Outlet>& all, std::size_t outlet);

/// The camera rests: its transform is sent again only where it differs from the last one.
class CameraTransform {
 public:
  /// Of a message of Topic::Transforms. Throws nlohmann's exception where it is none.
  [[nodiscard]] bool repeats(const std::string& bytes);

 private:
  std::string last_;
};

}  // namespace colift::ros2
