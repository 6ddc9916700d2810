#include "perception/reference_image.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

namespace colift::perception {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

hal::DepthFrame flat_frame(float depth_m) {
  hal::DepthFrame frame;
  frame.intrinsics = {64, 48, 60.0, 60.0, 32.0, 24.0};
  frame.depth_m.assign(64 * 48, depth_m);
  return frame;
}

std::size_t at(int u, int v) {
  return static_cast<std::size_t>(v * 64 + u);
}

hal::Result<ReferenceImage> build(const std::vector<hal::DepthFrame>& frames) {
  return build_reference(frames, hal::Pose::Identity(), NoiseModel{});
}

TEST_CASE("the reference is the mean of its frames, with their spread", "[partner][reference]") {
  std::mt19937 random(1);
  std::normal_distribution<float> noise(0.0F, 0.005F);
  std::vector<hal::DepthFrame> frames(30, flat_frame(2.0F));
  double sum = 0.0, squares = 0.0;
  for (auto& frame : frames) {
    for (auto& d : frame.depth_m) d += noise(random);
    const double e = frame.depth_m[at(10, 10)] - 2.0;
    sum += e;
    squares += e * e;
  }
  const double mean = 2.0 + sum / 30.0;
  const auto reference = build(frames);
  REQUIRE(reference);
  CHECK(reference->frames == 30);
  CHECK(reference->count[at(10, 10)] == 30);
  CHECK(reference->cloud.depth_m[at(10, 10)] == Approx(mean).margin(1e-5));
  CHECK(reference->spread_m[at(10, 10)] ==
        Approx(std::sqrt(squares / 30 - (mean - 2) * (mean - 2))).epsilon(1e-3));
  CHECK(reference->near_m[at(10, 10)] < mean);
  CHECK(reference->cloud.z[at(10, 10)] == reference->cloud.depth_m[at(10, 10)]);
  CHECK(reference->restless < 0.001);
}

TEST_CASE("one frame is a reference too", "[partner][reference]") {
  auto frame = flat_frame(1.5F);
  frame.depth_m[at(3, 4)] = kNan;
  const auto reference = build({frame});
  REQUIRE(reference);
  CHECK(reference->cloud.depth_m[at(0, 0)] == 1.5F);
  CHECK(reference->spread_m[at(0, 0)] == 0.0F);
  CHECK_FALSE(reference->cloud.seen(at(3, 4)));
  CHECK(std::isnan(reference->near_m[at(3, 4)]));
  CHECK(reference->count[at(3, 4)] == 0);
}

TEST_CASE("a pixel that some frames missed is the mean of the others", "[partner][reference]") {
  std::vector<hal::DepthFrame> frames(10, flat_frame(2.0F));
  for (std::size_t i = 0; i < 7; ++i) frames[i].depth_m[at(5, 5)] = i % 2 == 0 ? kNan : 0.0F;
  frames[8].depth_m[at(5, 5)] = 2.01F;
  const auto reference = build(frames);
  REQUIRE(reference);
  CHECK(reference->count[at(5, 5)] == 3);
  CHECK(reference->cloud.depth_m[at(5, 5)] == Approx(2.0 + 0.01 / 3).margin(1e-5));
}

TEST_CASE("at an edge the reference shows one of the two surfaces, not their mean", "[partner][reference]") {
  std::vector<hal::DepthFrame> frames(15, flat_frame(2.0F));
  for (std::size_t i = 0; i < 5; ++i) frames[3 * i].depth_m[at(20, 20)] = 1.2F;
  const auto reference = build(frames);
  REQUIRE(reference);
  CHECK(reference->cloud.depth_m[at(20, 20)] == Approx(2.0).margin(1e-4));
  CHECK(reference->near_m[at(20, 20)] == 1.2F);
  CHECK(reference->spread_m[at(20, 20)] < 0.001F);
}

TEST_CASE("a scene in which somebody walks is refused as reference", "[partner][reference]") {
  std::vector<hal::DepthFrame> frames(10, flat_frame(2.0F));
  for (int i = 0; i < 10; ++i) {
    for (int v = 0; v < 48; ++v) {
      for (int u = 5 * i; u < 5 * i + 12; ++u) frames[static_cast<std::size_t>(i)].depth_m[at(u, v)] = 1.4F;
    }
  }
  const auto reference = build(frames);
  REQUIRE_FALSE(reference);
  CHECK(reference.error().code == hal::ErrorCode::NotFound);
  CHECK(reference.error().detail.find("something moved") != std::string::npos);
}

TEST_CASE("frames that cannot be compared are named", "[partner][reference]") {
  CHECK(build({}).error().code == hal::ErrorCode::BadInput);

  auto small = flat_frame(1.0F);
  small.intrinsics.width = 32;
  small.depth_m.resize(32 * 48);
  const auto mixed = build({flat_frame(1.0F), small});
  REQUIRE_FALSE(mixed);
  CHECK(mixed.error().where == "reference image: frame 1");
  CHECK(mixed.error().detail == "32 x 48 pixels, the first frame has 64 x 48");

  auto torn = flat_frame(1.0F);
  torn.depth_m.resize(100);
  CHECK(build({torn}).error().detail == "100 depth values for 64 x 48 pixels");

  CHECK(build({flat_frame(kNan), flat_frame(0.0F)}).error().code == hal::ErrorCode::NotFound);
  CHECK(build({flat_frame(std::numeric_limits<float>::infinity())}).error().code == hal::ErrorCode::NotFound);
}

}  // namespace
}  // namespace colift::perception
