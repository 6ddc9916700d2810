#pragma once

#include <algorithm>
#include <cstring>
#include <deque>
#include <functional>
#include <memory>
#include <vector>

#include "hal/datagram_link.hpp"

namespace colift::sim_hal {

/// Two ends of a wire in memory, for tests and lock-step runs: what one end sends, the other one receives.
/// There is no time of its own: `clock` is the test's, and a receive() that finds nothing calls
/// `while_waiting` with the moment until which it would wait. That call lets the far end run and moves the
/// clock; it returns false when nothing more will come. One thread.
class MemoryWire {
 public:
  using WhileWaiting = std::function<bool(hal::Timestamp until)>;

  explicit MemoryWire(const hal::Clock& clock) : clock_(clock) {}

  /// The end at `own`. The wire has to outlive its ends.
  [[nodiscard]] std::unique_ptr<hal::DatagramLink> end(const hal::Endpoint& own,
                                                       WhileWaiting while_waiting = {}) {
    return std::make_unique<End>(*this, own, std::move(while_waiting));
  }

  /// Puts a datagram on the wire that nobody of the two sent: garbage, foreign senders.
  void inject(const hal::Endpoint& from, const hal::Endpoint& to, std::span<const std::byte> bytes) {
    queue_.push_back({from, to, {bytes.begin(), bytes.end()}});
  }

 private:
  struct Letter {
    hal::Endpoint from, to;
    std::vector<std::byte> bytes;
  };

  class End final : public hal::DatagramLink {
   public:
    End(MemoryWire& wire, const hal::Endpoint& own, WhileWaiting waiting)
        : wire_(wire), own_(own), waiting_(std::move(waiting)) {}
    hal::Result<> open() override {
      open_ = true;
      return {};
    }
    void close() noexcept override { open_ = false; }

    hal::Datagram receive(std::span<std::byte> into, hal::Duration timeout) noexcept override {
      hal::Datagram got;
      got.arrived_at = wire_.clock_.now();
      if (!open_) {
        got.kind = hal::Datagram::Kind::Broken;
        return got;
      }
      const hal::Timestamp until = got.arrived_at + timeout;
      while (!take(into, got)) {
        if (wire_.clock_.now() >= until || !waiting_ || !waiting_(until)) break;
      }
      got.arrived_at = wire_.clock_.now();
      return got;
    }

    bool send(const hal::Endpoint& to, std::span<const std::byte> bytes) noexcept override {
      if (!open_) return false;
      wire_.queue_.push_back({own_, to, {bytes.begin(), bytes.end()}});
      return true;
    }

   private:
    bool take(std::span<std::byte> into, hal::Datagram& got) {
      const auto it = std::find_if(wire_.queue_.begin(), wire_.queue_.end(),
                                   [&](const Letter& l) { return l.to == own_; });
      if (it == wire_.queue_.end()) return false;
      got.kind = hal::Datagram::Kind::Data;
      got.size = it->bytes.size();
      got.from = it->from;
      std::memcpy(into.data(), it->bytes.data(), std::min(into.size(), got.size));
      wire_.queue_.erase(it);
      return true;
    }

    MemoryWire& wire_;
    hal::Endpoint own_;
    WhileWaiting waiting_;
    bool open_ = false;
  };

  const hal::Clock& clock_;
  std::deque<Letter> queue_;
};

}  // namespace colift::sim_hal
