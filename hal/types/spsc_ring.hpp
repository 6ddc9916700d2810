#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <utility>

namespace colift::hal {

/// A bounded queue from one thread to one other thread; neither ever waits. `Size` is a power of two.
template <class T, std::size_t Size>
class SpscRing {
  static_assert(Size > 1 && (Size & (Size - 1)) == 0, "a power of two");

 public:
  /// Producing thread only. False when the queue is full: the value is dropped, and whoever pushes counts it.
  bool push(T value) {
    const std::size_t tail = tail_.load(std::memory_order_relaxed);
    if (tail - head_.load(std::memory_order_acquire) == Size) return false;
    places_[tail & (Size - 1)] = std::move(value);
    tail_.store(tail + 1, std::memory_order_release);
    return true;
  }

  /// Consuming thread only. False when there is nothing.
  bool pop(T& into) {
    const std::size_t head = head_.load(std::memory_order_relaxed);
    if (head == tail_.load(std::memory_order_acquire)) return false;
    into = std::move(places_[head & (Size - 1)]);
    head_.store(head + 1, std::memory_order_release);
    return true;
  }

 private:
  std::array<T, Size> places_{};
  alignas(64) std::atomic<std::size_t> head_{0};
  alignas(64) std::atomic<std::size_t> tail_{0};
};

}  // namespace colift::hal
