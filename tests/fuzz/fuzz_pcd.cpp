#include <cstdint>

#include "hal/drivers/recorded/cloud_files/pcd.hpp"
#include "hal/drivers/recorded/frame_file.hpp"

// What parses also goes through the search for its camera: the fit must stand any numbers, too.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace colift::hal;
  const auto points = parse_pcd(std::as_bytes(std::span(data, size)), "fuzz.pcd");
  if (points && points->size() <= 600) (void)frame_from_points(*points, "fuzz.pcd");
  return 0;
}
