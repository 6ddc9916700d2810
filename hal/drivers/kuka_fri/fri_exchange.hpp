#pragma once

#include <array>
#include <memory>

#include "hal/datagram_link.hpp"
#include "hal/drivers/kuka_fri/wire/answer_times.hpp"
#include "hal/drivers/kuka_fri/wire/fri_codec.hpp"
#include "hal/drivers/kuka_fri/wire/packet_gate.hpp"

namespace colift::hal {

/// Datagrams in, datagrams out: takes the newest good one, answers it once, counts. Real-time safe after
/// open().
class FriExchange {
 public:
  FriExchange(std::unique_ptr<DatagramLink> link, const Clock& clock, const Endpoint& krc, FriChecks checks,
              bool check_sequence)
      : link_(std::move(link)), clock_(clock), gate_(krc, checks, check_sequence) {}

  [[nodiscard]] Result<> open() { return link_->open(); }
  void close() noexcept { link_->close(); }

  /// Forgets sender and counts.
  void reset() noexcept;

  enum class Got { Packet, Nothing, Broken };
  struct Packet {
    int cycles = 1;          ///< Since the last one.
    bool first = false;      ///< Of all, or after a lost link.
    bool restarted = false;  ///< The KRC counts anew.
    Timestamp arrived_at{0};
  };
  /// Waits until `until`. Of a queue of good datagrams only the newest is taken.
  Got receive(Timestamp until, double period_s, FriMeasurement& m, Packet& packet) noexcept;

  /// Answers the datagram that was received last; sets the header. False when it could not be sent.
  bool answer(FriCommand& command) noexcept;

  /// Answers of the last ones that the KRC had not received when it sent `m`; 0 when it does not reflect.
  [[nodiscard]] int unheard(const FriMeasurement& m) const noexcept;

  [[nodiscard]] PacketGate& gate() { return gate_; }
  [[nodiscard]] const PacketGate& gate() const { return gate_; }
  [[nodiscard]] const AnswerTimes& answer_times() const { return times_; }
  [[nodiscard]] FriRefusal last_refusal() const { return last_refusal_; }

  std::uint64_t received = 0, answered = 0, late = 0, unsent = 0, lost = 0;

 private:
  std::unique_ptr<DatagramLink> link_;
  const Clock& clock_;
  PacketGate gate_;
  AnswerTimes times_;
  FriRefusal last_refusal_ = FriRefusal::None;
  std::uint16_t send_ = 0, reflect_ = 0;
  Endpoint to_;
  Timestamp arrived_at_{0};
  double period_s_ = 0.0;
  // longer than a datagram, so that a long one is seen to be long
  std::array<std::byte, 2048> in_{};
  std::array<std::byte, kFriCommandBytes> out_{};
};

}  // namespace colift::hal
