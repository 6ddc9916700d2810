#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace colift::tests {

/// A serialised message with its four bytes of encapsulation: on the wire "00 01 00 00" and plain
/// little-endian CDR.
using Bytes = std::vector<unsigned char>;

/// How an endpoint of a peer behaves.
struct PeerQos {
  bool reliable = true, latched = false;
  int depth = 10;
};

/// A participant of the other implementation, Fast DDS, that knows no types: it sends and receives bytes
/// under any name, true or not. On the loopback interface; shares no code with the product.
class FastPeer {
 public:
  class Reader {
   public:
    virtual ~Reader() = default;
    /// The next message; unset where none came in time.
    [[nodiscard]] virtual std::optional<Bytes> next(std::chrono::milliseconds timeout) = 0;
    /// GUID of a writer that it is matched with, 16 bytes; empty without one.
    [[nodiscard]] virtual Bytes matched_writer() = 0;
  };
  class Writer {
   public:
    virtual ~Writer() = default;
    virtual bool write(const Bytes& message) = 0;
    /// Waits until so many readers are there.
    virtual bool wait_for_readers(int count, std::chrono::milliseconds timeout) = 0;
  };

  /// `all_interfaces`: as a node of ROS 2 without any setting, otherwise 127.0.0.1 alone.
  explicit FastPeer(int domain, bool all_interfaces = false);
  ~FastPeer();

  /// `topic`: "rt/joint_states"; `type`: "sensor_msgs::msg::dds_::JointState_".
  [[nodiscard]] std::unique_ptr<Reader> reader(const std::string& topic, const std::string& type,
                                               PeerQos qos = {});
  [[nodiscard]] std::unique_ptr<Writer> writer(const std::string& topic, const std::string& type,
                                               PeerQos qos = {});

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace colift::tests
