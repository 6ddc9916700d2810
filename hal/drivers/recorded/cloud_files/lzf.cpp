#include "hal/drivers/recorded/cloud_files/lzf.hpp"

#include <cstring>

namespace colift::hal {

std::optional<std::size_t> expand_lzf(Bytes in, std::span<std::byte> out) {
  std::size_t from = 0, to = 0;
  while (to < out.size()) {
    if (from >= in.size()) return std::nullopt;
    const auto control = std::to_integer<unsigned>(in[from++]);
    if (control < 32) {
      const std::size_t run = control + 1;
      if (run > in.size() - from || run > out.size() - to) return std::nullopt;
      std::memcpy(out.data() + to, in.data() + from, run);
      from += run;
      to += run;
      continue;
    }
    std::size_t length = control >> 5;
    if (length == 7) {
      if (from >= in.size()) return std::nullopt;
      length += std::to_integer<unsigned>(in[from++]);
    }
    length += 2;
    if (from >= in.size()) return std::nullopt;
    const std::size_t distance = ((control & 31u) << 8) + std::to_integer<unsigned>(in[from++]) + 1;
    if (distance > to || length > out.size() - to) return std::nullopt;
    // byte by byte: source and target may overlap, which repeats a pattern
    for (std::size_t i = 0; i < length; ++i, ++to) out[to] = out[to - distance];
  }
  return from;
}

}  // namespace colift::hal
