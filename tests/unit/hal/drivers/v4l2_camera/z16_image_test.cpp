#include "hal/drivers/v4l2_camera/z16_image.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "hal/drivers/v4l2_camera/stamp_gate.hpp"

namespace colift::hal::v4l2 {
namespace {

using namespace std::chrono_literals;

DepthModel small() {
  return {{16, 16, 20.0, 20.0, 8.0, 8.0}, {}, 0.001};
}

std::vector<std::uint8_t> picture(std::size_t stride, unsigned units) {
  std::vector<std::uint8_t> bytes(stride * 16, 0xee);
  for (std::size_t v = 0; v < 16; ++v)
    for (std::size_t u = 0; u < 16; ++u) {
      bytes[v * stride + 2 * u] = static_cast<std::uint8_t>(units & 0xffU);
      bytes[v * stride + 2 * u + 1] = static_cast<std::uint8_t>(units >> 8U);
    }
  return bytes;
}

void put(std::vector<std::uint8_t>& bytes, std::size_t pixel, unsigned units) {
  bytes[2 * pixel] = static_cast<std::uint8_t>(units & 0xffU);
  bytes[2 * pixel + 1] = static_cast<std::uint8_t>(units >> 8U);
}

}  // namespace

TEST_CASE("a Z16 picture becomes metres by the unit that the file says", "[v4l2]") {
  const DepthRange range{0.15, 10.0};
  for (const auto& [unit_m, units, expected_m] :
       {std::tuple{0.001, 1500U, 1.5f}, std::tuple{0.0001, 15000U, 1.5f}, std::tuple{0.00025, 600U, 0.15f}}) {
    DepthModel model = small();
    model.unit_m = unit_m;
    const auto depth = depth_of({picture(32, units), 32}, model, range);
    REQUIRE(depth);
    CHECK(depth->size() == 256);
    CHECK(std::all_of(depth->begin(), depth->end(), [e = expected_m](float z) { return z == e; }));
  }
}

TEST_CASE("rows may be padded, and the last one may end early", "[v4l2]") {
  auto bytes = picture(48, 2000);
  bytes.resize(bytes_of(small().intrinsics, 48));
  const auto depth = depth_of({bytes, 48}, small(), {});
  REQUIRE(depth);
  CHECK(std::all_of(depth->begin(), depth->end(), [](float z) { return z == 2.0f; }));
}

TEST_CASE("what is no depth is NaN: nothing, saturated, too near, too far", "[v4l2]") {
  auto bytes = picture(32, 1000);
  put(bytes, 0, 0), put(bytes, 1, 0xffff), put(bytes, 2, 149), put(bytes, 3, 10001);
  put(bytes, 4, 150), put(bytes, 5, 10000);
  const auto depth = depth_of({bytes, 32}, small(), {0.15, 10.0});
  REQUIRE(depth);
  for (std::size_t i = 0; i < 4; ++i) CHECK(std::isnan((*depth)[i]));
  CHECK((*depth)[4] == 0.15f);
  CHECK((*depth)[5] == 10.0f);
}

TEST_CASE("a picture that contradicts its size is refused with the figures", "[v4l2]") {
  const auto bytes = picture(32, 1000);
  const auto narrow = depth_of({bytes, 31}, small(), {});
  REQUIRE_FALSE(narrow);
  CHECK(narrow.error().code == ErrorCode::BadReply);
  CHECK_THAT(narrow.error().detail, Catch::Contains("31") && Catch::Contains("32"));
  const auto cut = depth_of({std::span(bytes).first(511), 32}, small(), {});
  REQUIRE_FALSE(cut);
  CHECK_THAT(cut.error().detail, Catch::Contains("511") && Catch::Contains("512"));
  CHECK_FALSE(depth_of({bytes, std::numeric_limits<std::size_t>::max() / 32}, small(), {}));
}

TEST_CASE("a lens of the file is taken out of the picture", "[v4l2]") {
  DepthModel model = small();
  model.lens.k1 = 0.5;
  REQUIRE(check(model));
  auto bytes = picture(32, 1000);
  put(bytes, 0, 3000);
  const auto with = depth_of({bytes, 32}, model, {});
  const auto without = depth_of({bytes, 32}, small(), {});
  REQUIRE(with);
  REQUIRE(without);
  CHECK((*without)[0] == 3.0f);
  // the ray of the corner is imaged outside the picture
  CHECK(std::isnan((*with)[0]));
  CHECK((*with)[8 * 16 + 8] == 1.0f);
}

TEST_CASE("a model that cannot be is refused before a device is opened", "[v4l2]") {
  struct Wrong {
    const char* expected;
    void (*change)(DepthModel&);
  };
  for (const Wrong& w : {
           Wrong{"size", [](DepthModel& m) { m.intrinsics.width = 0; }},
           Wrong{"size", [](DepthModel& m) { m.intrinsics.height = 1 << 20; }},
           Wrong{"focal", [](DepthModel& m) { m.intrinsics.fx = std::nan(""); }},
           Wrong{"principal point", [](DepthModel& m) { m.intrinsics.cy = 17.0; }},
           Wrong{"unit", [](DepthModel& m) { m.unit_m = 0.0; }},
           Wrong{"unit", [](DepthModel& m) { m.unit_m = 1.0; }},
           Wrong{"two rays", [](DepthModel& m) { m.lens.k1 = -5.0; }},
       }) {
    DepthModel model = small();
    w.change(model);
    const auto ok = check(model);
    REQUIRE_FALSE(ok);
    CHECK(ok.error().code == ErrorCode::BadConfig);
    CHECK_THAT(ok.error().detail, Catch::Contains(w.expected));
  }
}

TEST_CASE("stamps that cannot be are refused, and the next good one passes", "[v4l2]") {
  StampGate gate(0.3, 0.01);
  const Timestamp now = 100s;
  CHECK(gate.pass(now - 20ms, now).value() == now - 20ms);
  CHECK_THAT(gate.pass(now - 20ms, now + 10ms).error().detail, Catch::Contains("older than the one before"));
  CHECK_THAT(gate.pass(now + 500ms, now + 20ms).error().detail, Catch::Contains("in the future"));
  CHECK_THAT(gate.pass(now - 400ms, now + 20ms).error().detail, Catch::Contains("old by its stamp"));
  CHECK_THAT(gate.pass(-5s, now + 20ms).error().detail, Catch::Contains("old by its stamp"));
  // a little ahead is the clock's grain
  CHECK(gate.pass(now + 35ms, now + 30ms).value() == now + 30ms);
  CHECK(gate.pass(now + 50ms, now + 60ms).value() == now + 50ms);
}

}  // namespace colift::hal::v4l2
