#include <catch2/catch.hpp>
#include <cmath>
#include <random>

#include "hal/drivers/recorded/depth_png.hpp"
#include "writers.hpp"

using namespace colift::hal;
using namespace colift::hal::test;

TEST_CASE("a depth PNG gives every value times its scale, and NaN for zero", "[png]") {
  std::mt19937 random(1);
  for (const bool interlaced : {false, true}) {
    for (const double scale_m : {0.001, 0.0001}) {
      std::vector<std::uint16_t> values(37 * 21);
      for (auto& value : values) value = static_cast<std::uint16_t>(random() % 4 == 0 ? 0 : random());
      const auto image =
          parse_depth_png(bytes_of(png(37, 21, 16, false, interlaced, values)), "d.png", scale_m);
      REQUIRE(image);
      CHECK(image->width == 37);
      CHECK(image->height == 21);
      for (std::size_t i = 0; i < values.size(); ++i) {
        if (values[i] == 0) {
          REQUIRE(std::isnan(image->depth_m[i]));
        } else {
          REQUIRE(image->depth_m[i] == static_cast<float>(values[i] * scale_m));
        }
      }
    }
  }
}

TEST_CASE("an image of another kind is no depth image", "[png]") {
  const std::vector<std::uint16_t> values(3 * 4 * 5, 9);
  const auto grey = parse_depth_png(bytes_of(png(12, 5, 8, false, false, values)), "d.png", 0.001);
  REQUIRE_FALSE(grey);
  CHECK(grey.error().text() == "d.png: header: the image is 8-bit grey; a depth image is 16-bit grey");
  const auto colour = parse_depth_png(bytes_of(png(4, 5, 16, true, false, values)), "d.png", 0.001);
  REQUIRE_FALSE(colour);
  CHECK(colour.error().text() == "d.png: header: the image is 16-bit colour; a depth image is 16-bit grey");
}

TEST_CASE("a PNG cut at any place is refused", "[png]") {
  std::vector<std::uint16_t> values(64 * 48);
  std::mt19937 random(3);
  for (auto& value : values) value = static_cast<std::uint16_t>(random());
  const std::string whole = png(64, 48, 16, false, false, values);
  for (std::size_t cut = 0; cut < whole.size(); cut += 97) {
    CHECK_FALSE(parse_depth_png(bytes_of(whole.substr(0, cut)), "cut.png", 0.001));
  }
}

TEST_CASE("a PNG with a byte changed is refused by its checksums", "[png]") {
  std::vector<std::uint16_t> values(64 * 48);
  std::mt19937 random(4);
  for (auto& value : values) value = static_cast<std::uint16_t>(random());
  const std::string whole = png(64, 48, 16, false, false, values);
  for (int round = 0; round < 100; ++round) {
    std::string damaged = whole;
    char& byte = damaged[random() % damaged.size()];
    byte = static_cast<char>(byte ^ static_cast<char>(1 + random() % 255));
    CHECK_FALSE(parse_depth_png(bytes_of(damaged), "damaged.png", 0.001));
  }
}
