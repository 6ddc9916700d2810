#pragma once

#include <array>
#include <atomic>

namespace colift::hal {

/// The latest value of any type that can be copied, from one writing thread to one reading thread: neither
/// ever waits for the other. Three places: one is written, one is read, one lies between and is exchanged
/// (triple buffer). T is assigned in place, so a T whose copy does not allocate keeps both sides free of
/// allocation.
template <class T>
class TripleBuffer {
 public:
  TripleBuffer() = default;
  explicit TripleBuffer(const T& initial) { places_.fill(initial); }

  /// Writing thread only.
  void write(const T& value) {
    places_[back_] = value;
    back_ = between_.exchange(back_ | kNew, std::memory_order_acq_rel) & kPlace;
  }

  /// Reading thread only: true when there was a newer value than the last one read.
  bool read(T& into) {
    if ((between_.load(std::memory_order_relaxed) & kNew) == 0) return false;
    front_ = between_.exchange(front_, std::memory_order_acq_rel) & kPlace;
    into = places_[front_];
    return true;
  }

 private:
  static constexpr unsigned kNew = 4, kPlace = 3;
  std::array<T, 3> places_{};
  alignas(64) unsigned back_ = 0;
  alignas(64) std::atomic<unsigned> between_{1};
  alignas(64) unsigned front_ = 2;
};

}  // namespace colift::hal
