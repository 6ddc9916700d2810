#pragma once

#include <cstdint>
#include <optional>
#include <vector>

namespace colift::sim_hal {

/// Which cycles of a mock suffer which fault. Later entries win where they overlap.
template <class Fault>
class FaultPlan {
 public:
  /// Cycles `first` to `first + count - 1`.
  void inject(Fault fault, std::uint64_t first, std::uint64_t count) {
    entries_.push_back({fault, first, count});
  }

  [[nodiscard]] std::optional<Fault> at(std::uint64_t cycle) const {
    for (auto it = entries_.rbegin(); it != entries_.rend(); ++it)
      if (cycle >= it->first && cycle - it->first < it->count) return it->fault;
    return std::nullopt;
  }

 private:
  struct Entry {
    Fault fault;
    std::uint64_t first, count;
  };
  std::vector<Entry> entries_;
};

}  // namespace colift::sim_hal
