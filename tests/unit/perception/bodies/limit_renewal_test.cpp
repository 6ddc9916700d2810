#include "perception/bodies/limit_renewal.hpp"

#include <catch2/catch.hpp>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

using namespace colift::perception;

namespace {

constexpr std::size_t kWidth = 64, kHeight = 48, kBlocks = kWidth / 4 * (kHeight / 4);

/// A box 1 m away before a wall 3 m away, and the limits that stand before them: at the box's edges, which
/// are ragged, the box's.
struct Wall {
  std::vector<float> depth_m = std::vector<float>(kWidth * kHeight, 3.0F), limit_m;
  std::vector<float> behind_m = std::vector<float>(kBlocks, 3.0F);
  std::vector<std::uint8_t> robot = std::vector<std::uint8_t>(kBlocks, 0);
  NoiseModel noise;
  ChangeConfig change;

  Wall() {
    fill(16, 32, 1.0F, depth_m);
    limit_m = std::vector<float>(kWidth * kHeight, 2.9F);
    fill(10, 38, 0.95F, limit_m);
  }
  static void fill(std::size_t from, std::size_t to, float value, std::vector<float>& image) {
    for (std::size_t v = from; v < to; ++v)
      for (std::size_t u = from; u < to; ++u) image[v * kWidth + u] = value;
  }
  [[nodiscard]] LimitRenewal renewal(std::vector<std::uint8_t> keeps = {}) const {
    return {depth_m, kWidth, noise, change, std::move(keeps)};
  }
  std::size_t look(LimitRenewal& renewal, const std::vector<float>& seen, int frames) {
    std::size_t moved = 0;
    for (int i = 0; i < frames; ++i) moved += renewal.update(seen, robot, limit_m, behind_m);
    return moved;
  }
};

}  // namespace

TEST_CASE("what stands as it stood is compared with as before, at its edges too") {
  Wall wall;
  const auto before = wall.limit_m;
  LimitRenewal renewal = wall.renewal();
  CHECK(wall.look(renewal, wall.depth_m, 60) == 0);
  CHECK(wall.limit_m == before);
}

TEST_CASE("where a thing was carried off, what stood behind it is the scene half a second later") {
  Wall wall;
  LimitRenewal renewal = wall.renewal();
  const std::vector<float> gone(kWidth * kHeight, 3.0F);
  CHECK(wall.look(renewal, gone, 12) == 0);  // four looks
  CHECK(wall.look(renewal, gone, 3) == 16);  // its 4 x 4 blocks, a third of the rows with each frame
  CHECK(wall.limit_m[24 * kWidth + 24] > 2.8F);
  CHECK(wall.limit_m[24 * kWidth + 24] < 3.0F);
  CHECK(wall.limit_m[12 * kWidth + 12] == 0.95F);  // beside it the reference has not changed
  CHECK(wall.look(renewal, gone, 30) == 0);        // once

  SECTION("somebody who passes before that is no scene") {
    Wall other;
    LimitRenewal anew = other.renewal();
    CHECK(other.look(anew, gone, 12) == 0);
    CHECK(other.look(anew, other.depth_m, 3) == 0);
    CHECK(other.look(anew, gone, 12) == 0);
  }
}

TEST_CASE(
    "nothing is renewed where the object was, where the robot is, without measurements, or in a speck") {
  Wall wall;
  std::vector<float> gone(kWidth * kHeight, 3.0F);
  std::vector<std::uint8_t> keeps(kBlocks, 0);
  SECTION("the object") {
    keeps.assign(kBlocks, 1);
  }
  SECTION("the robot") {
    wall.robot.assign(kBlocks, 1);
  }
  SECTION("no measurements") {
    gone.assign(kWidth * kHeight, std::numeric_limits<float>::quiet_NaN());
  }
  SECTION("a speck") {
    gone = wall.depth_m;
    for (std::size_t v = 20; v < 24; ++v)
      for (std::size_t u = 20; u < 24; ++u) gone[v * kWidth + u] = 3.0F;
  }
  LimitRenewal renewal = wall.renewal(keeps);
  CHECK(wall.look(renewal, gone, 60) == 0);
}
