#pragma once

#include <cstddef>
#include <cstdlib>

namespace colift::tests {

/// Whether a story tries this combination of fault and phase. Each fault is tried in every third phase, and in
/// all of them where COLIFT_ALL_FAULTS is set: the whole table takes minutes.
[[nodiscard]] inline bool chosen(std::size_t fault, std::size_t phase) {
  static const bool all = std::getenv("COLIFT_ALL_FAULTS") != nullptr;
  return all || (fault + phase) % 3 == 0;
}

}  // namespace colift::tests
