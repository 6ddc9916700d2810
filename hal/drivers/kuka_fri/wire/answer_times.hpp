#pragma once

#include <array>
#include <atomic>
#include <cstdint>

#include "hal/types/time.hpp"

namespace colift::hal {

/// Histogram of the time from a datagram's arrival to its answer. Fixed buckets that grow by a quarter of
/// their octave from 1 us to 0.5 s. One thread adds, any thread reads; nobody waits.
class AnswerTimes {
 public:
  static constexpr std::size_t kBuckets = 80;
  static constexpr std::size_t kSlow = 256;

  void add(Duration took) noexcept {
    const std::uint64_t us = took.count() > 0 ? (static_cast<std::uint64_t>(took.count()) + 999) / 1000 : 0;
    counts_[bucket(us)].fetch_add(1, std::memory_order_relaxed);
    if (us > worst_us_.load(std::memory_order_relaxed)) worst_us_.store(us, std::memory_order_relaxed);
  }

  /// One that took too long, beside add(); the first kSlow of them are kept with their times.
  void note_slow(Timestamp arrived, Timestamp answered) noexcept {
    const std::size_t i = slow_.load(std::memory_order_relaxed);
    if (i >= kSlow) return;
    slow_at_[i] = {arrived, answered};
    slow_.store(i + 1, std::memory_order_release);
  }

  void reset() noexcept {
    slow_.store(0, std::memory_order_relaxed);
    for (auto& c : counts_) c.store(0, std::memory_order_relaxed);
    worst_us_.store(0, std::memory_order_relaxed);
  }

  [[nodiscard]] std::uint64_t count() const noexcept {
    std::uint64_t sum = 0;
    for (const auto& c : counts_) sum += c.load(std::memory_order_relaxed);
    return sum;
  }
  [[nodiscard]] std::uint64_t worst_us() const noexcept { return worst_us_.load(std::memory_order_relaxed); }

  /// Upper edge of the bucket in which the part `p` (0 to 1) of all answers lies (us); 0 without answers.
  [[nodiscard]] std::uint64_t percentile_us(double p) const noexcept {
    const std::uint64_t all = count();
    if (all == 0) return 0;
    std::uint64_t sum = 0;
    for (std::size_t i = 0; i < kBuckets; ++i) {
      sum += counts_[i].load(std::memory_order_relaxed);
      if (static_cast<double>(sum) >= p * static_cast<double>(all)) return upper_us(i);
    }
    return upper_us(kBuckets - 1);
  }

  struct Slow {
    Timestamp arrived{0}, answered{0};
  };
  [[nodiscard]] std::size_t slow() const noexcept { return slow_.load(std::memory_order_acquire); }
  [[nodiscard]] const Slow& slow(std::size_t i) const noexcept { return slow_at_[i]; }

  /// Answers in one bucket, and its upper edge (included): for drawing.
  [[nodiscard]] std::uint64_t in_bucket(std::size_t i) const noexcept {
    return counts_[i].load(std::memory_order_relaxed);
  }
  [[nodiscard]] static constexpr std::uint64_t upper_us(std::size_t i) noexcept {
    if (i < 4) return i;
    const std::size_t octave = i / 4 + 1, quarter = i % 4;
    return (std::uint64_t{1} << octave) + (quarter + 1) * (std::uint64_t{1} << (octave - 2)) - 1;
  }

 private:
  [[nodiscard]] static constexpr std::size_t bucket(std::uint64_t us) noexcept {
    std::size_t low = 0, high = kBuckets - 1;
    while (low < high) {
      const std::size_t middle = (low + high) / 2;
      if (us <= upper_us(middle))
        high = middle;
      else
        low = middle + 1;
    }
    return low;
  }

  std::array<std::atomic<std::uint64_t>, kBuckets> counts_{};
  std::atomic<std::uint64_t> worst_us_{0};
  std::array<Slow, kSlow> slow_at_{};
  std::atomic<std::size_t> slow_{0};
};

}  // namespace colift::hal
