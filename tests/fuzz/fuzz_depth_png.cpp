#include <cstdint>

#include "hal/drivers/recorded/depth_png.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  (void)colift::hal::parse_depth_png(std::as_bytes(std::span(data, size)), "fuzz.png", 0.001);
  return 0;
}
