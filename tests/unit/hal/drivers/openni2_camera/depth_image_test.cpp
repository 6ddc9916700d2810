// Images as OpenNI2 hands them out, and as they leave the ring: what is taken, and what is refused.

#include <array>
#include <catch2/catch.hpp>
#include <cmath>

#include "hal/drivers/openni2_camera/depth_frame.hpp"
#include "hal/drivers/openni2_camera/depth_image.hpp"

using namespace colift::hal;
using namespace colift::hal::openni2;

namespace {

constexpr DepthMode kSmall{16, 16, 30, kUnit_1mm};

struct Image {
  std::vector<std::uint16_t> pixels = std::vector<std::uint16_t>(20UL * 16);
  ImageView view{pixels.data(), 20 * 16 * 2, 16, 16, 20 * 2, false};
  Image() {
    for (std::size_t i = 0; i < pixels.size(); ++i) pixels[i] = static_cast<std::uint16_t>(i);
  }
};

}  // namespace

TEST_CASE("the mode nearest to 640 x 480 at 30 Hz is taken, in millimetres first", "[openni2]") {
  const std::array<DepthMode, 7> all{{{320, 240, 30, kUnit_1mm},
                                      {640, 480, 60, kUnit_1mm},
                                      {640, 480, 30, kUnit_100um},
                                      {640, 480, 30, kUnit_1mm},
                                      {1280, 1024, 30, kUnit_1mm},
                                      {4096, 4096, 30, kUnit_1mm},
                                      {640, 480, 30, 0}}};
  CHECK(choose_mode(all, {}) == 3U);
  CHECK(choose_mode(all, {0, 0, 0, kUnit_100um}) == 2U);
  CHECK(choose_mode(all, {320, 0, 0, 0}) == 0U);
  CHECK(choose_mode(all, {0, 0, 60, 0}) == 1U);
  CHECK(choose_mode(all, {1280, 1024, 30, kUnit_1mm}) == 4U);
  CHECK_FALSE(choose_mode(all, {4096, 0, 0, 0}));  // larger than the memory for it
  CHECK_FALSE(choose_mode(all, {320, 0, 60, 0}));
  CHECK_FALSE(choose_mode({}, {}));
}

TEST_CASE("sizes that cannot be are no mode, and overflow nothing", "[openni2]") {
  const std::array<DepthMode, 5> all{{{0, 480, 30, kUnit_1mm},
                                      {-640, -480, 30, kUnit_1mm},
                                      {2147483647, 2147483647, 30, kUnit_1mm},
                                      {640, 15, 30, kUnit_1mm},
                                      {640, 480, 30, 1}}};
  CHECK_FALSE(choose_mode(all, {}));
}

TEST_CASE("an image is copied without the padding of its rows, and turned round when it is mirrored",
          "[openni2]") {
  const Image image;
  std::vector<std::uint16_t> to;
  REQUIRE_FALSE(copy_image(image.view, kSmall, false, to));
  REQUIRE(to.size() == 256);
  CHECK(to[0] == 0);
  CHECK(to[15] == 15);
  CHECK(to[16] == 20);
  REQUIRE_FALSE(copy_image(image.view, kSmall, true, to));
  CHECK(to[0] == 15);
  CHECK(to[15] == 0);
  CHECK(to[16] == 35);
}

TEST_CASE("an image that is not what its mode says is refused before a byte of it is read", "[openni2]") {
  const Image image;
  const std::vector<std::uint16_t> before{7};
  const auto refused = [&](auto change) {
    ImageView v = image.view;
    change(v);
    std::vector<std::uint16_t> to = before;
    const auto reason = copy_image(v, kSmall, false, to);
    return reason && !reason->empty() && to == before;
  };
  CHECK(refused([](ImageView& v) { v.width = 17; }));
  CHECK(refused([](ImageView& v) { v.height = 8; }));
  CHECK(refused([](ImageView& v) { v.height = -16; }));
  CHECK(refused([](ImageView& v) { v.stride = 31; }));
  CHECK(refused([](ImageView& v) { v.stride = -40; }));
  CHECK(refused([](ImageView& v) { v.stride = 2147483647; }));
  CHECK(refused([](ImageView& v) { v.bytes = 40 * 15 + 31; }));
  CHECK(refused([](ImageView& v) { v.bytes = -1; }));
  CHECK(refused([](ImageView& v) { v.data = nullptr; }));
  CHECK(refused([](ImageView& v) { v.cropped = true; }));
  CHECK_FALSE(refused([](ImageView& v) { v.bytes = 40 * 15 + 32; }));  // the last row without padding
}

TEST_CASE("units become metres within the range; nothing and the largest value are no depth", "[openni2]") {
  capture::RawFrame raw;
  raw.stamp.width = 3;
  raw.stamp.height = 2;
  raw.stamp.unit_um = kUnit_1mm;
  raw.pixels = {0, 100, 1500, 9999, 10001, 0xffff};
  const PinholeModel model{{3, 2, 100.0, 100.0, 1.5, 1.0}, {}};
  const auto mm = depth_of(raw, model, 0.15, 10.0);
  REQUIRE(mm);
  CHECK(std::isnan((*mm)[0]));
  CHECK(std::isnan((*mm)[1]));
  CHECK((*mm)[2] == 1.5f);
  CHECK((*mm)[3] == 9.999f);
  CHECK(std::isnan((*mm)[4]));
  CHECK(std::isnan((*mm)[5]));
  raw.stamp.unit_um = kUnit_100um;
  raw.pixels[2] = 15004;
  CHECK((*depth_of(raw, model, 0.15, 10.0))[2] == Approx(1.5004f));
  raw.stamp.unit_um = 250;
  CHECK(depth_of(raw, model, 0.15, 10.0).error().code == ErrorCode::BadReply);
  raw.stamp.unit_um = kUnit_1mm;
  raw.stamp.width = 2;
  CHECK(depth_of(raw, model, 0.15, 10.0).error().code == ErrorCode::BadReply);
  raw.stamp.width = 3;
  raw.pixels.pop_back();
  CHECK(depth_of(raw, model, 0.15, 10.0).error().code == ErrorCode::BadReply);
}

TEST_CASE("the field of view gives the focal length, and one that no camera has is not believed",
          "[openni2]") {
  // PS1080's: 1.0144686707507438 and 0.78980943449644714 rad
  const CameraIntrinsics k = intrinsics_of({1.0144686707507438, 0.78980943449644714}, 640, 480);
  CHECK(k.fx == Approx(576.1).epsilon(1e-3));
  CHECK(k.fy == Approx(576.1).epsilon(1e-3));
  CHECK(k.cx == 320.0);
  CHECK(k.cy == 240.0);
  CHECK(plausible(openni2::FieldOfView{1.01, 0.79}));
  CHECK_FALSE(plausible(openni2::FieldOfView{0.0, 0.79}));
  CHECK_FALSE(plausible(openni2::FieldOfView{1.01, 3.2}));
  CHECK_FALSE(plausible(openni2::FieldOfView{std::nan(""), 0.79}));
}
