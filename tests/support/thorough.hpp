#pragma once

#include <cstddef>
#include <cstdlib>

namespace colift::tests {

/// COLIFT_THOROUGH is set: stories go through whole tables, which takes many minutes.
[[nodiscard]] inline bool thorough() {
  static const bool set = std::getenv("COLIFT_THOROUGH") != nullptr;
  return set;
}

/// This program was built with a sanitizer and takes some seven times as long. A sanitizer judges code, not
/// figures: every story runs, with fewer repetitions.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
inline constexpr bool kSanitized = true;
#else
inline constexpr bool kSanitized = false;
#endif

/// How many random layouts, or kept runs, a story goes through.
[[nodiscard]] constexpr int repetitions(int usually, int sanitized) {
  return kSanitized ? sanitized : usually;
}

/// Whether a story tries this combination of fault and phase: each fault in every third phase, and in all of
/// them where it is to be thorough.
[[nodiscard]] inline bool chosen(std::size_t fault, std::size_t phase) {
  return thorough() || (fault + phase) % (kSanitized ? 9 : 3) == 0;
}

}  // namespace colift::tests
