#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "hal/datagram_link.hpp"
#include "hal/drivers/kuka_fri/wire/fri_codec.hpp"

namespace colift::hal {

/// Why a datagram was thrown away.
enum class FriDrop : std::uint8_t {
  None,
  Sender,      ///< Not from the KRC.
  Size,        ///< Short or long.
  Header,      ///< Another id or size in its header.
  Content,     ///< Not a number, or what cannot be.
  Doubled,     ///< The same counter again.
  Old,         ///< Reordered: a newer one came before.
  Ahead,       ///< Its counter is further ahead than time has passed.
  Superseded,  ///< Good, but a newer one was waiting behind it.
};
inline constexpr std::size_t kFriDrops = 9;
[[nodiscard]] std::string_view to_string(FriDrop drop) noexcept;

/// Lets through what the KRC sent, once and in order. The first good datagram locks its sender in (of those
/// that `krc` allows). Counters are compared as signed 16-bit differences. A sender that counts anew is
/// believed once nothing else came for a while. Real-time safe.
class PacketGate {
 public:
  /// `krc`: address and port 0 mean any.
  PacketGate(const Endpoint& krc, FriChecks checks, bool check_sequence)
      : krc_(krc), checks_(checks), check_sequence_(check_sequence) {}

  struct Passed {
    FriDrop drop = FriDrop::None;
    FriRefusal refusal = FriRefusal::None;
    int cycles = 1;          ///< Since the last one that passed; 1 for the first.
    bool first = false;      ///< Of all, or after unlock().
    bool restarted = false;  ///< The sender counts anew.
  };

  /// `period_s` of the datagrams, for plausible counters. `out` is set when nothing was dropped.
  Passed look(const Datagram& got, std::span<const std::byte> bytes, double period_s,
              FriMeasurement& out) noexcept;
  void count(FriDrop drop) noexcept { ++drops_[static_cast<std::size_t>(drop)]; }

  /// Nothing came for long: the KRC may come back with another port and another counter.
  void unlock() noexcept;
  void reset() noexcept {
    sender_.reset();
    rival_.reset();
    unlock();
    drops_.fill(0);
  }
  [[nodiscard]] const std::optional<Endpoint>& sender() const { return sender_; }
  /// Who else sends datagrams of a measurement's size from where the KRC may send: one of the two is not the
  /// KRC. Forgotten when it takes the sender's place.
  struct Rival {
    Endpoint who;
    Timestamp at{0};  ///< Of its last datagram.
    std::uint64_t datagrams = 0;
  };
  [[nodiscard]] const std::optional<Rival>& rival() const { return rival_; }
  /// Datagrams come, but on from another counter: by how far it was set (less than 0: back); 0: it was not.
  [[nodiscard]] int counter_set_by() const noexcept;
  [[nodiscard]] const std::array<std::uint64_t, kFriDrops>& drops() const { return drops_; }

 private:
  [[nodiscard]] bool allowed(const Endpoint& from) const;
  [[nodiscard]] bool foreign(const Endpoint& from) const;
  void note_rival(const Datagram& got);
  [[nodiscard]] FriDrop order(std::uint16_t send, Timestamp at, double period_s, Passed& passed);

  Endpoint krc_;
  FriChecks checks_;
  bool check_sequence_;
  std::optional<Endpoint> sender_;
  std::optional<Rival> rival_;
  std::optional<std::uint16_t> last_;
  Timestamp last_at_{0}, first_at_{0};
  double counted_s_ = 0.0;  ///< Periods counted since first_at_.
  std::uint16_t out_of_line_ = 0;
  int in_line_ = 0;
  std::array<std::uint64_t, kFriDrops> drops_{};
};

}  // namespace colift::hal
