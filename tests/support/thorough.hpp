#pragma once

#include <cstddef>
#include <cstdlib>

namespace colift::tests {

/// COLIFT_THOROUGH is set: stories go through whole tables, which takes many minutes.
[[nodiscard]] inline bool thorough() {
  static const bool set = std::getenv("COLIFT_THOROUGH") != nullptr;
  return set;
}

/// Whether a story tries this combination of fault and phase: each fault in every third phase, and in all of
/// them where it is to be thorough.
[[nodiscard]] inline bool chosen(std::size_t fault, std::size_t phase) {
  return thorough() || (fault + phase) % 3 == 0;
}

}  // namespace colift::tests
