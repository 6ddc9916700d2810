#pragma once

#include <cstdint>

namespace colift::sim_hal {

/// 64 well mixed bits for a place in a stream: the same three numbers always give the same bits, in any order
/// of asking, on any machine (multiply and xor-shift rounds over a Weyl step, as in SplitMix64; Steele, Lea,
/// Flood 2014).
[[nodiscard]] constexpr std::uint64_t hash(std::uint64_t seed, std::uint64_t stream, std::uint64_t index) {
  std::uint64_t h =
      seed * 0xd1342543de82ef95ULL + stream * 0xaf251af3b0f025b5ULL + (index + 1) * 0x9e3779b97f4a7c15ULL;
  h = (h ^ (h >> 30)) * 0xbf58476d1ce4e5b9ULL;
  h = (h ^ (h >> 27)) * 0x94d049bb133111ebULL;
  return h ^ (h >> 31);
}

/// The upper 53 bits as a number in [0, 1).
[[nodiscard]] constexpr double unit(std::uint64_t bits) {
  return static_cast<double>(bits >> 11) * 0x1p-53;
}

/// Numbers drawn one after the other, for scenes: the draw order is the code's order.
class Draws {
 public:
  Draws(std::uint64_t seed, std::uint64_t stream) : seed_(seed), stream_(stream) {}

  [[nodiscard]] double between(double low, double high) { return low + (high - low) * unit(next()); }
  [[nodiscard]] bool chance(double probability) { return unit(next()) < probability; }
  /// 0 to count - 1.
  [[nodiscard]] int below(int count) { return static_cast<int>(unit(next()) * count); }

 private:
  std::uint64_t next() { return hash(seed_, stream_, index_++); }

  std::uint64_t seed_, stream_, index_ = 0;
};

}  // namespace colift::sim_hal
