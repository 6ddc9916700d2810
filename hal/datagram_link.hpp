#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "hal/types/result.hpp"
#include "hal/types/time.hpp"

namespace colift::hal {

/// An IPv4 address and port, both in host byte order. Port 0: any.
struct Endpoint {
  std::uint32_t address = 0;
  std::uint16_t port = 0;
  friend bool operator==(const Endpoint&, const Endpoint&) = default;
};

/// What one receive() brought.
struct Datagram {
  enum class Kind {
    None,    ///< Nothing came in time.
    Data,    ///< `size` bytes; more than the buffer holds are cut, and `size` still tells them all.
    Broken,  ///< The link itself does not work; open() it again.
  };
  Kind kind = Kind::None;
  std::size_t size = 0;
  Endpoint from;
  Timestamp arrived_at{0};  ///< Of the link's clock.
};

/// Datagrams to and from one local port: the seam under the arm's driver and under the emulated controller.
/// UDP on the robot and on loopback, memory in tests. One thread, after open().
class DatagramLink {
 public:
  virtual ~DatagramLink() = default;

  /// Errors: LinkLost (port in use, address not of this machine), BadConfig. May allocate.
  [[nodiscard]] virtual Result<> open() = 0;
  virtual void close() noexcept = 0;

  /// Waits for a datagram, no longer than `timeout`; zero only looks. Real-time safe.
  [[nodiscard]] virtual Datagram receive(std::span<std::byte> into, Duration timeout) noexcept = 0;

  /// False when it could not be sent: nothing is queued then. Real-time safe, never waits.
  virtual bool send(const Endpoint& to, std::span<const std::byte> bytes) noexcept = 0;
};

}  // namespace colift::hal
