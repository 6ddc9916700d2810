#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "hal/dds/qos.hpp"
#include "hal/types/result.hpp"

struct dds_topic_descriptor;

namespace colift::hal::dds {

/// Where a participant lives.
struct DdsConfig {
  int domain = 0;
  std::string interface = "lo";  ///< Network interface; "lo": sockets of this machine alone.
  std::string node = "colift";   ///< Name for `ros2 node list`.
};

/// One DDS participant that looks like a node of ROS 2. Readers and writers are handles of Cyclone DDS and
/// live as long as it does. Samples that are larger than 32 MiB are dropped before any memory is taken for
/// them. Any thread.
///
/// All participants of one domain in one process share the network settings of the first.
class Participant {
 public:
  /// Errors: BadConfig (no such interface, settings of this domain differ), DeviceFault (what Cyclone DDS
  /// reports).
  [[nodiscard]] static Result<std::unique_ptr<Participant>> open(const DdsConfig& config);
  ~Participant();
  Participant(const Participant&) = delete;
  Participant& operator=(const Participant&) = delete;

  /// `ros_name`: "/joint_states". Errors: BadConfig (name), DeviceFault.
  [[nodiscard]] Result<std::int32_t> writer(const std::string& ros_name, const dds_topic_descriptor& type,
                                            Qos qos);
  [[nodiscard]] Result<std::int32_t> reader(const std::string& ros_name, const dds_topic_descriptor& type,
                                            Qos qos);

  /// The handle of Cyclone DDS.
  [[nodiscard]] std::int32_t handle() const;

 private:
  struct Impl;
  explicit Participant(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace colift::hal::dds
