// Any values as what OpenNI2 says of an image, and any numbers and time stamps of frames: refused with a
// reason, or a depth image of the mode's size within the range; and times that never go back or lie ahead.

#include <cmath>
#include <cstdint>
#include <cstring>

#include "hal/drivers/openni2_camera/depth_frame.hpp"
#include "hal/drivers/openni2_camera/depth_image.hpp"
#include "hal/drivers/openni2_camera/frame_gate.hpp"
#include "tests/fuzz/demand.hpp"

using colift::fuzz::demand;
using namespace colift::hal;

namespace {

void image(const std::uint8_t* data, std::size_t size) {
  struct Head {
    std::int32_t bytes, width, height, stride;
    std::uint16_t mode_width, mode_height, unit_um;
    std::uint8_t cropped, mirrored;
    double across_rad, down_rad;
  } head{};
  if (size < sizeof head) return;
  std::memcpy(&head, data, sizeof head);
  data += sizeof head;
  size -= sizeof head;
  const openni2::DepthMode offered{head.mode_width % 80, head.mode_height % 80, 30, head.unit_um};
  if (!openni2::choose_mode(std::span(&offered, 1), {})) return;
  // what is said of an image is no more than what is there: the library's own memory
  const openni2::ImageView view{data,        std::min(head.bytes, static_cast<std::int32_t>(size)),
                                head.width,  head.height,
                                head.stride, head.cropped != 0};
  capture::RawFrame raw;
  if (const auto wrong = copy_image(view, offered, head.mirrored != 0, raw.pixels)) {
    demand(!wrong->empty() && raw.pixels.empty());
    return;
  }
  const openni2::FieldOfView field{head.across_rad, head.down_rad};
  if (!plausible(field)) return;
  raw.stamp.width = static_cast<std::uint32_t>(offered.width);
  raw.stamp.height = static_cast<std::uint32_t>(offered.height);
  raw.stamp.unit_um = offered.unit_um;
  const openni2::PinholeModel model{intrinsics_of(field, offered.width, offered.height), {}};
  demand(std::isfinite(model.intrinsics.fx) && model.intrinsics.fx > 0.0);
  const auto depth_m = depth_of(raw, model, 0.15, 10.0);
  demand(depth_m && depth_m->size() == raw.pixels.size());
  for (const float z : *depth_m) demand(std::isnan(z) || (z >= 0.149F && z <= 10.001F));
}

void times(const std::uint8_t* data, std::size_t size) {
  struct Frame {
    std::uint64_t index, stamp_us;
    std::uint32_t passed_us;
  } f{};
  openni2::FrameGate gate;
  Timestamp now = std::chrono::seconds(10), last = Timestamp::min();
  for (; size >= sizeof f; data += sizeof f, size -= sizeof f) {
    std::memcpy(&f, data, sizeof f);
    now += std::chrono::microseconds(f.passed_us);
    const auto passed = gate.pass(f.index, f.stamp_us, now);
    if (!passed) {
      demand(!passed.error().detail.empty());
      continue;
    }
    demand(passed->exposed > last && passed->exposed <= now);
    last = passed->exposed;
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  if (data[0] % 2 == 0)
    image(data + 1, size - 1);
  else
    times(data + 1, size - 1);
  return 0;
}
