#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace colift::picture {

/// A film as one animated PNG (PNG third edition, W3C: chunks acTL, fcTL, fdAT), which browsers play without
/// a script and which other programs show as its first picture. Plays again and again; each picture stays for
/// `frame_s`, the last one for `last_s` (s, up to 60). After the first, only the rectangle that changed is
/// stored, and in it only the pixels that did. `frames`: opaque pixels, 3 bytes each, width * height,
/// row-major; those of another size are left out. Empty without a frame.
[[nodiscard]] std::vector<std::uint8_t> animated_png(int width, int height,
                                                     std::span<const std::vector<std::uint8_t>> frames,
                                                     double frame_s, double last_s);

}  // namespace colift::picture
