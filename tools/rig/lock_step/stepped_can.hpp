#pragma once

#include <atomic>
#include <chrono>
#include <memory>
#include <thread>
#include <utility>

#include "hal/can_bus.hpp"
#include "sim_hal/emulator/memory_can_bus.hpp"

namespace colift {

/// One end of a real bus in a test's time: a frame that the other end has sent is waited for, however long
/// the machine takes, and arrives at the moment of its sending; what nobody has sent is not looked for. So
/// drivers of real transports run in lock step, as over MemoryCan, and the same calls give the same states.
class SteppedCan final : public hal::CanBus {
 public:
  SteppedCan(std::unique_ptr<hal::CanBus> bus, const hal::Clock& clock)
      : bus_(std::move(bus)), clock_(clock) {}

  void join(SteppedCan& other) { other_ = &other, other.other_ = this; }
  /// As MemoryCan's; an end without it never waits.
  sim_hal::MemoryCan::WhileWaiting while_waiting;

  hal::Result<> open() override {
    coming_ = 0;
    // a gateway greets its clients only while somebody looks
    std::atomic<bool> done{false};
    std::thread far([this, &done] {
      hal::CanFrame frame;
      while (!done && other_ != nullptr && other_->open_)
        (void)other_->bus_->receive(frame, std::chrono::milliseconds(1));
    });
    auto opened = bus_->open();
    done = true;
    far.join();
    open_ = opened.has_value();
    return opened;
  }

  void close() noexcept override {
    open_ = false;
    bus_->close();
  }

  Received receive(hal::CanFrame& into, hal::Duration timeout) noexcept override {
    const hal::Timestamp until = clock_.now() + timeout;
    for (;;) {
      if (coming_ > 0) {
        --coming_;
        const Received got = fetch(into);
        if (got == Received::Nothing) ++lost_;
        if (got != Received::Nothing) return got;
        continue;
      }
      const hal::Timestamp now = clock_.now();
      if (now >= until || !while_waiting) return Received::Nothing;
      if (!while_waiting(until) && coming_ == 0) return Received::Nothing;
    }
  }

  Sent send(const hal::CanFrame& frame) noexcept override {
    const Sent sent = bus_->send(frame);
    if (sent == Sent::Yes && other_->open_) ++other_->coming_;
    return sent;
  }

  hal::CanHealth health() const noexcept override { return bus_->health(); }
  /// Frames that did not come at all.
  [[nodiscard]] int lost() const { return lost_; }

 private:
  Received fetch(hal::CanFrame& into) noexcept {
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(5);
    while (std::chrono::steady_clock::now() < end) {
      const Received got = bus_->receive(into, std::chrono::milliseconds(100));
      if (got == Received::Nothing) continue;
      into.arrived_at = clock_.now();
      return got;
    }
    return Received::Nothing;
  }

  std::unique_ptr<hal::CanBus> bus_;
  const hal::Clock& clock_;
  SteppedCan* other_ = nullptr;
  std::atomic<bool> open_{false};
  int coming_ = 0, lost_ = 0;
};

}  // namespace colift
