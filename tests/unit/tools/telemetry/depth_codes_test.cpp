#include "tools/telemetry/channels/depth_codes.hpp"

#include <bit>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <random>

#include "sim_hal/synthetic/kinect/kinect_code.hpp"
#include "tools/telemetry/replay/export.hpp"

namespace {

using namespace colift;
using telemetry::NumberedFrame;

bool same_bits(const std::vector<float>& a, const std::vector<float>& b) {
  if (a.size() != b.size()) return false;
  for (std::size_t i = 0; i < a.size(); ++i)
    if (std::bit_cast<std::uint32_t>(a[i]) != std::bit_cast<std::uint32_t>(b[i])) return false;
  return true;
}

NumberedFrame frame_of(int width, int height) {
  NumberedFrame n;
  n.number = 41;
  n.frame.exposed_at = hal::Timestamp(123456789);
  n.frame.intrinsics = {width, height, 575.8, 575.9, 320.1, 240.2};
  n.frame.up_C = hal::Vec3(0.1, -0.9, 0.3);
  n.frame.depth_m.resize(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  return n;
}

void check_round_trip(const NumberedFrame& n) {
  const auto back = telemetry::decode_depth(telemetry::encode_depth(n));
  REQUIRE(back);
  CHECK(back->number == n.number);
  CHECK(back->frame.exposed_at == n.frame.exposed_at);
  CHECK(back->frame.intrinsics.fy == n.frame.intrinsics.fy);
  CHECK(back->frame.up_C == n.frame.up_C);
  CHECK(back->frame.rgb == n.frame.rgb);
  CHECK(same_bits(back->frame.depth_m, n.frame.depth_m));
}

}  // namespace

TEST_CASE("a Kinect's frame comes back to the bit", "[depth]") {
  std::mt19937 random(5);
  const auto& table = sim_hal::kinect_depths_m();
  NumberedFrame n = frame_of(64, 48);
  for (float& d : n.frame.depth_m) d = table[random() % table.size()];
  check_round_trip(n);
  n.frame.rgb = {1, 2, 3};
  n.frame.up_C.reset();
  check_round_trip(n);
}

TEST_CASE("any floats come back to the bit, odd ones and NaNs with a payload too", "[depth]") {
  std::mt19937 random(6);
  NumberedFrame n = frame_of(100, 80);
  for (float& d : n.frame.depth_m) d = std::bit_cast<float>(static_cast<std::uint32_t>(random()));
  check_round_trip(n);
  n.frame.depth_m.assign(n.frame.depth_m.size(), std::bit_cast<float>(0x7fc00001u));
  n.frame.depth_m[7] = -0.0f;
  n.frame.depth_m[8] = std::numeric_limits<float>::infinity();
  check_round_trip(n);
  n.frame.depth_m.resize(13);  // not as many as the size says
  check_round_trip(n);
  n.frame.depth_m.clear();
  check_round_trip(n);
}

TEST_CASE("a frame cut anywhere is refused", "[depth]") {
  NumberedFrame n = frame_of(16, 4);
  for (std::size_t i = 0; i < n.frame.depth_m.size(); ++i)
    n.frame.depth_m[i] = 0.5f + 0.001f * static_cast<float>(i % 7);
  const std::string bytes = telemetry::encode_depth(n);
  for (std::size_t cut = 0; cut < bytes.size(); ++cut)
    REQUIRE_FALSE(telemetry::decode_depth(std::string_view(bytes).substr(0, cut)));
  std::mt19937 random(7);
  for (int i = 0; i < 20000; ++i) {
    std::string bad = bytes;
    bad[random() % bad.size()] = static_cast<char>(random());
    (void)telemetry::decode_depth(bad);  // survives
  }
}

TEST_CASE("every depth of a Kinect finds a code that has this depth", "[depth]") {
  const auto& table = sim_hal::kinect_depths_m();
  int checked = 0;
  for (int raw = 400; raw < sim_hal::kKinectCodes; ++raw) {
    const float depth = table[static_cast<std::size_t>(raw) + 1];
    const std::uint16_t code = telemetry::kinect_code(depth);
    if (code == 2047) continue;
    REQUIRE(code < sim_hal::kKinectCodes);
    CHECK(table[static_cast<std::size_t>(code) + 1] == depth);
    ++checked;
  }
  CHECK(checked > 600);
  CHECK(telemetry::kinect_code(std::nanf("")) == 2047);
  CHECK(telemetry::kinect_code(0.0f) == 2047);
}
