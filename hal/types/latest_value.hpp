#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <cstring>
#include <type_traits>

namespace colift::hal {

/// The newest value of one writer for any number of readers. Writing never waits; a reader that was overtaken
/// reads again. (A sequence lock: H.-J. Boehm, "Can seqlocks get along with programming language memory
/// models?", 2012. Ordered by the words themselves, without fences, so that the thread sanitizer sees it.)
template <class T>
class LatestValue {
  static_assert(std::is_trivially_copyable_v<T>);

 public:
  LatestValue() { write(T{}); }

  /// One thread only. Real-time safe.
  void write(const T& value) noexcept {
    std::array<std::uint64_t, kWords> words{};
    std::memcpy(words.data(), static_cast<const void*>(&value), sizeof(T));
    const std::uint64_t turn = turn_.load(std::memory_order_relaxed);
    turn_.store(turn + 1, std::memory_order_relaxed);  // odd: being written
    for (std::size_t i = 0; i < kWords; ++i) words_[i].store(words[i], std::memory_order_release);
    turn_.store(turn + 2, std::memory_order_release);
  }

  /// Any thread. Never a mix of two values.
  [[nodiscard]] T read() const noexcept {
    for (;;) {
      std::array<std::uint64_t, kWords> words{};
      const std::uint64_t before = turn_.load(std::memory_order_acquire);
      for (std::size_t i = 0; i < kWords; ++i) words[i] = words_[i].load(std::memory_order_acquire);
      if (before % 2 == 0 && turn_.load(std::memory_order_relaxed) == before) {
        T value;
        std::memcpy(static_cast<void*>(&value), words.data(), sizeof(T));
        return value;
      }
    }
  }

  /// How many values were written after the first, empty one.
  [[nodiscard]] std::uint64_t count() const noexcept { return turn_.load(std::memory_order_acquire) / 2 - 1; }

 private:
  static constexpr std::size_t kWords = (sizeof(T) + 7) / 8;
  std::atomic<std::uint64_t> turn_{0};
  std::array<std::atomic<std::uint64_t>, kWords> words_{};
};

}  // namespace colift::hal
