#include "hal/types/add_bits.hpp"

#include "hal/types/avx2.hpp"

namespace colift::hal {

COLIFT_ALSO_AVX2 void add_bits(const std::uint8_t* __restrict from, int n, std::uint8_t* __restrict to) {
  for (int i = 0; i < n; ++i) to[i] |= from[i];
}

}  // namespace colift::hal
