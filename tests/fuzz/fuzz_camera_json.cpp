#include <cstdint>

#include "hal/drivers/recorded/camera_file.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  (void)colift::hal::parse_camera_json(std::as_bytes(std::span(data, size)), "camera.json");
  return 0;
}
