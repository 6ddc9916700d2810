#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <string>

#include "hal/dds/participant.hpp"
#include "tools/telemetry/channels/channels.hpp"

namespace colift::ros2 {

struct PublisherConfig {
  hal::dds::DdsConfig dds;
  std::size_t queue_messages =
      256;  ///< Beyond either the oldest is dropped, but for the newest of what lasts (is_lasting()).
  std::size_t queue_bytes = 32u << 20;
};

struct PublisherCounts {
  std::uint64_t handed_in = 0, dropped = 0;  ///< Messages of channels; the queue was full.
  std::uint64_t written = 0,
                failed = 0;  ///< Messages of ROS 2; what Cyclone DDS refused or the channel lacked.
};

/// Publishes a run to ROS 2, in a thread of its own. Topics: docs/ros2.md. A message is made only if somebody
/// subscribed to its topic, or if the topic is latched.
///
/// Stamps are ROS time: the robot's clock, moved by its difference to the system's clock; set anew where it
/// is more than 50 ms off, as in a simulation that is not in real time.
class Ros2Publisher final : public telemetry::TelemetrySink {
 public:
  /// Errors: BadConfig (domain, interface), DeviceFault (what Cyclone DDS reports).
  [[nodiscard]] static hal::Result<std::unique_ptr<Ros2Publisher>> open(const PublisherConfig& config);
  ~Ros2Publisher() override;

  /// Any thread but the arm's; a short lock, no system call.
  void publish(const telemetry::Publication& publication) override;
  /// Waits until all messages were written and acknowledged by those that asked for reliable ones. False: not
  /// in time.
  bool flush(std::chrono::milliseconds timeout);
  [[nodiscard]] PublisherCounts counts() const;

 private:
  struct Impl;
  explicit Ros2Publisher(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace colift::ros2
