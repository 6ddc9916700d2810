#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "hal/datagram_link.hpp"
#include "sim_hal/emulator/krc/krc_faults.hpp"

namespace colift::sim_hal {

/// One way of a bad wire: what goes in comes out late, twice, in another order, spoiled or never. Same seed
/// and same datagrams: same faults.
class KrcBadWire {
 public:
  using Out = std::function<void(std::span<const std::byte>, const hal::Endpoint&, hal::Timestamp)>;

  KrcBadWire(const std::vector<KrcFault>& faults, KrcFault::Direction way, std::uint64_t seed, Out out);

  /// `t_s`: the controller's time, by which faults happen; `now`: the clock of the datagrams.
  void pass(std::span<const std::byte> bytes, const hal::Endpoint& peer, double t_s, hal::Timestamp now);
  /// Lets out what is due.
  void flush(double t_s, hal::Timestamp now);
  [[nodiscard]] std::optional<hal::Timestamp> next_due() const;
  void clear();
  void add(const KrcFault& fault);
  /// No fault any more; what is held back is gone.
  void mend();

 private:
  struct Letter {
    std::vector<std::byte> bytes;
    hal::Endpoint peer;
    hal::Timestamp due{0};
  };
  struct Active {
    KrcFault fault;
    std::uint64_t count = 0;  // datagrams that it has met
    std::vector<Letter> held;
  };

  [[nodiscard]] bool suffers(const Active& a, double t_s) const;
  void spoil(std::vector<std::byte>& bytes, std::uint64_t stream) const;
  void release(Active& a, hal::Timestamp now);

  KrcFault::Direction path_;
  std::vector<Active> faults_;
  std::uint64_t seed_, passed_ = 0;
  Out out_;
  std::vector<Letter> delayed_;
};

}  // namespace colift::sim_hal
