// Any values as the model of a video device and a picture of it: refused with a reason, or a depth image of
// the model's size without a depth beyond the range that was asked for.

#include <cmath>
#include <cstdint>
#include <cstring>

#include "hal/drivers/v4l2_camera/z16_image.hpp"
#include "tests/fuzz/demand.hpp"

using colift::fuzz::demand;
using namespace colift::hal;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  struct Head {
    std::uint16_t width, height, stride;
    std::uint8_t lens;
    double fx, fy, cx, cy, unit_m, k1, k2;
  } head{};
  if (size < sizeof(head)) return 0;
  std::memcpy(&head, data, sizeof(head));
  v4l2::DepthModel model;
  // small, so that the picture that follows can be whole
  model.intrinsics = {head.width % 80, head.height % 80, head.fx, head.fy, head.cx, head.cy};
  model.unit_m = head.unit_m;
  if (head.lens % 2 == 1) model.lens.k1 = head.k1, model.lens.k2 = head.k2;
  const auto good = v4l2::check(model);
  if (!good) {
    demand(!good.error().detail.empty());
    return 0;
  }
  const v4l2::DepthRange range;
  const auto depth_m =
      v4l2::depth_of({{data + sizeof(head), size - sizeof(head)}, head.stride}, model, range);
  if (!depth_m) {
    demand(!depth_m.error().detail.empty());
    return 0;
  }
  demand(depth_m->size() == static_cast<std::size_t>(model.intrinsics.width * model.intrinsics.height));
  for (const float z : *depth_m) demand(std::isnan(z) || (z >= 0.0F && z <= range.max_m));
  return 0;
}
