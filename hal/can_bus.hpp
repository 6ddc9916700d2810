#pragma once

#include <array>
#include <cstdint>

#include "hal/types/result.hpp"
#include "hal/types/time.hpp"

namespace colift::hal {

/// One classic CAN data frame with an 11-bit identifier. Remote and extended frames never come up to here.
struct CanFrame {
  std::uint16_t id = 0;  ///< 0 to 0x7ff.
  std::uint8_t length = 0;
  std::array<std::uint8_t, 8> data{};
  Timestamp arrived_at{
      0};  ///< Of reception, CLOCK_MONOTONIC or the bus's own clock; 0 in a frame to be sent.
  friend bool operator==(const CanFrame& a, const CanFrame& b) {
    return a.id == b.id && a.length == b.length && a.data == b.data;
  }
};

/// Frames that pass: those with (frame.id & mask) == id.
struct CanFilter {
  std::uint16_t id = 0, mask = 0;
};

/// How the bus is, from error frames and the carrier: what write() says is not believed.
struct CanHealth {
  enum class State { Closed, Down, Active, Warning, Passive, BusOff };
  State state = State::Closed;
  std::uint64_t received = 0, sent = 0;
  std::uint64_t dropped =
      0;  ///< Frames of a kind that nobody here uses, broken ones, and those lost in a full queue.
  std::uint64_t not_sent = 0;  ///< The queue was full.
  std::uint64_t error_frames = 0;
  bool reports_errors =
      true;  ///< Error frames come here; of a gateway known from the first one on (option -e).
  std::uint64_t bus_offs = 0;
  std::uint64_t not_acknowledged = 0;  ///< Error frames that say so: nobody else is on the bus.
  std::uint64_t bus_errors = 0;  ///< Error frames about bits, stuffing or form: noise, or a wrong bit rate.
  std::uint8_t send_errors = 0, receive_errors = 0;  ///< The controller's own counters, as last reported.
};

/// A CAN bus: SocketCAN, a socketcand gateway, or memory. One thread.
class CanBus {
 public:
  enum class Received { Frame, Nothing, Down };
  enum class Sent { Yes, Full, Down };

  virtual ~CanBus() = default;

  /// Also after it went down. Errors: LinkLost, BadConfig (with what to do about it). May allocate and wait
  /// (a gateway: no longer than 2 s). Counters go on; the state starts anew.
  [[nodiscard]] virtual Result<> open() = 0;
  virtual void close() noexcept = 0;

  /// Waits for the next frame, no longer than `timeout`; zero only looks.
  [[nodiscard]] virtual Received receive(CanFrame& into, Duration timeout) noexcept = 0;

  /// Never waits. Full: the frame is known not to be sent.
  [[nodiscard]] virtual Sent send(const CanFrame& frame) noexcept = 0;

  [[nodiscard]] virtual CanHealth health() const noexcept = 0;
};

}  // namespace colift::hal
