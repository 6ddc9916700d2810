#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <optional>

namespace colift::hal {

/// A queue of fixed size from one thread to one other. Neither ever waits: what does not fit is refused and
/// counted.
template <class T, std::size_t kCapacity>
class SpscRing {
  static_assert(kCapacity > 0 && (kCapacity & (kCapacity - 1)) == 0, "a power of two");

 public:
  /// The writing thread. False when the ring is full.
  bool push(const T& value) noexcept {
    const std::size_t head = head_.load(std::memory_order_relaxed);
    if (head - tail_.load(std::memory_order_acquire) == kCapacity) {
      refused_.fetch_add(1, std::memory_order_relaxed);
      return false;
    }
    slots_[head % kCapacity] = value;
    head_.store(head + 1, std::memory_order_release);
    return true;
  }

  /// The reading thread. Empty when there is nothing.
  [[nodiscard]] std::optional<T> pop() noexcept {
    const std::size_t tail = tail_.load(std::memory_order_relaxed);
    if (tail == head_.load(std::memory_order_acquire)) return std::nullopt;
    const std::optional<T> value = slots_[tail % kCapacity];
    tail_.store(tail + 1, std::memory_order_release);
    return value;
  }

  /// How many values did not fit. Any thread.
  [[nodiscard]] std::uint64_t refused() const noexcept { return refused_.load(std::memory_order_relaxed); }

 private:
  std::array<T, kCapacity> slots_{};
  // apart, so that the two threads do not take each other's cache line
  alignas(64) std::atomic<std::size_t> head_{0};
  alignas(64) std::atomic<std::size_t> tail_{0};
  std::atomic<std::uint64_t> refused_{0};
};

}  // namespace colift::hal
