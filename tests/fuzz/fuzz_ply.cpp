#include <cstdint>

#include "hal/drivers/recorded/cloud_files/ply.hpp"
#include "hal/drivers/recorded/frame_file.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace colift::hal;
  const auto points = parse_ply(std::as_bytes(std::span(data, size)), "fuzz.ply");
  if (points && points->size() <= 600) (void)frame_from_points(*points, "fuzz.ply");
  return 0;
}
