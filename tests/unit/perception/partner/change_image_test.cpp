#include "perception/partner/change_image.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

namespace colift::perception {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr int kWidth = 200, kHeight = 90;  // no multiple of 64, to meet the ends of the words

hal::DepthFrame wall(float depth_m) {
  hal::DepthFrame frame;
  frame.intrinsics = {kWidth, kHeight, 200.0, 200.0, 100.0, 45.0};
  frame.depth_m.assign(kWidth * kHeight, depth_m);
  return frame;
}

void paint(hal::DepthFrame& frame, int u0, int v0, int u1, int v1, float depth_m) {
  for (int v = v0; v < v1; ++v) {
    for (int u = u0; u < u1; ++u) frame.depth_m[static_cast<std::size_t>(v * kWidth + u)] = depth_m;
  }
}

ChangeImage against(const hal::DepthFrame& reference) {
  return {build_reference({&reference, 1}, hal::Pose::Identity(), NoiseModel{}).value(), NoiseModel{},
          ChangeConfig{}, PixelWindow{0, 0, kWidth, kHeight}};
}

ChangeImage& compare(ChangeImage& change, const hal::DepthFrame& frame) {
  change.compare(deproject(frame, hal::Pose::Identity()));
  return change;
}

int pixels(const ChangeImage& change) {
  int n = 0;
  for (const auto& c : change.components()) n += c.pixels;
  return n;
}

TEST_CASE("noise is no change", "[partner][change]") {
  auto change = against(wall(2.0F));
  std::mt19937 random(3);
  std::normal_distribution<float> noise(0.0F, static_cast<float>(NoiseModel{}.sigma(2.0)));
  for (int i = 0; i < 10; ++i) {
    auto frame = wall(2.0F);
    for (auto& d : frame.depth_m) d += noise(random);
    CHECK(pixels(compare(change, frame)) == 0);
  }
}

TEST_CASE("a body before the wall is one component of its size", "[partner][change]") {
  auto change = against(wall(2.0F));
  auto frame = wall(2.0F);
  paint(frame, 50, 20, 150, 60, 1.5F);
  compare(change, frame);
  REQUIRE(change.components().size() == 1);
  CHECK(change.components()[0].pixels == 98 * 38);  // without its outermost pixel
  CHECK(change.components()[0].area_m2 == Approx(98 * 38 * 1.5 * 1.5 / (200.0 * 200.0)));
}

TEST_CASE("a body farther than the reference, or not seen, is no change", "[partner][change]") {
  auto change = against(wall(2.0F));
  auto frame = wall(2.0F);
  paint(frame, 20, 20, 80, 60, 2.6F);
  paint(frame, 100, 20, 150, 60, kNan);
  CHECK(pixels(compare(change, frame)) == 0);
}

TEST_CASE("specks and slivers are no change", "[partner][change]") {
  auto change = against(wall(2.0F));
  auto frame = wall(2.0F);
  for (int i = 0; i < 20; ++i) paint(frame, 10 * i, 5, 10 * i + 2, 7, 1.0F);
  paint(frame, 0, 40, kWidth, 42, 1.0F);
  CHECK(pixels(compare(change, frame)) == 0);
}

TEST_CASE("two bodies one before the other are two components", "[partner][change]") {
  auto change = against(wall(3.0F));
  auto frame = wall(3.0F);
  paint(frame, 30, 10, 170, 80, 2.0F);
  paint(frame, 80, 30, 120, 50, 1.5F);
  compare(change, frame);
  CHECK(change.components().size() == 2);
}

TEST_CASE("a forearm that slopes away stays one component", "[partner][change]") {
  auto change = against(wall(3.0F));
  auto frame = wall(3.0F);
  for (int u = 20; u < 180; ++u) paint(frame, u, 30, u + 1, 45, 1.2F + 0.006F * static_cast<float>(u - 20));
  compare(change, frame);
  CHECK(change.components().size() == 1);
}

TEST_CASE("a ragged edge of the object is no change on either side", "[partner][change]") {
  auto reference = wall(2.5F);
  paint(reference, 60, 20, 140, 70, 1.5F);
  auto change = against(reference);
  std::mt19937 random(5);
  auto frame = wall(2.5F);
  paint(frame, 60, 20, 140, 70, 1.5F);
  for (int v = 20; v < 70; ++v) {
    const int left = 60 + static_cast<int>(random() % 5) - 2,
              right = 140 + static_cast<int>(random() % 5) - 2;
    paint(frame, 56, v, left, v + 1, 2.5F);
    paint(frame, left, v, right, v + 1, 1.5F);
    paint(frame, right, v, 144, v + 1, 2.5F);
  }
  CHECK(pixels(compare(change, frame)) == 0);
}

TEST_CASE("a dropout that shows its surface again is no change, a body in it is", "[partner][change]") {
  auto reference = wall(2.0F);
  paint(reference, 80, 30, 120, 60, kNan);
  auto change = against(reference);
  CHECK(pixels(compare(change, wall(2.0F))) == 0);
  auto frame = wall(2.0F);
  paint(frame, 80, 30, 120, 60, 1.8F);
  CHECK(pixels(compare(change, frame)) ==
        38 * 28);  // the dropout is the reference's: the wall around it is seen
}

TEST_CASE("a hand in the object's shadow is seen against what is behind", "[partner][change]") {
  auto reference = wall(2.5F);
  paint(reference, 100, 0, kWidth, kHeight, 1.5F);
  paint(reference, 80, 0, 100, kHeight, kNan);
  auto change = against(reference);
  auto frame = reference;
  paint(frame, 80, 20, 100, 60, 1.7F);
  CHECK(pixels(compare(change, frame)) > 15 * 38);
}

TEST_CASE("where the reference saw nothing at all, whatever appears is new", "[partner][change]") {
  auto reference = wall(2.0F);
  paint(reference, 0, 0, kWidth, 50, kNan);
  auto change = against(reference);
  auto frame = wall(2.0F);
  paint(frame, 0, 0, kWidth, 50, kNan);
  paint(frame, 60, 10, 100, 30, 3.5F);
  CHECK(pixels(compare(change, frame)) == 40 * 20);  // nothing unchanged beside it: no pixel is lost
}

// Independent of bit masks and union-find: flood fill over single pixels.
int components_by_flood(const ChangeImage& change, const hal::DepthFrame& frame, int& count) {
  const auto inside = [](int u, int v) { return u >= 0 && v >= 0 && u < kWidth && v < kHeight; };
  const auto depth = [&](int u, int v) { return frame.depth_m[static_cast<std::size_t>(v * kWidth + u)]; };
  const auto raw = [&](int u, int v) {
    return inside(u, v) && depth(u, v) < change.limit(static_cast<std::size_t>(v * kWidth + u));
  };
  const auto mine = [&](int u, int v) { return raw(u, v) || (inside(u, v) && std::isnan(depth(u, v))); };
  const auto kept = [&](int u, int v) {
    return raw(u, v) && mine(u - 1, v) && mine(u + 1, v) && mine(u, v - 1) && mine(u, v + 1);
  };
  const NoiseModel noise;
  std::vector<bool> done(kWidth * kHeight, false);
  int components = 0;
  count = 0;
  std::vector<std::pair<int, int>> open;
  for (int v = 0; v < kHeight; ++v) {
    for (int u = 0; u < kWidth; ++u) {
      if (!kept(u, v) || done[static_cast<std::size_t>(v * kWidth + u)]) continue;
      ++components;
      open.assign(1, {u, v});
      done[static_cast<std::size_t>(v * kWidth + u)] = true;
      while (!open.empty()) {
        const auto [x, y] = open.back();
        open.pop_back();
        ++count;
        for (const auto& [dx, dy] : {std::pair{1, 0}, {-1, 0}, {0, 1}, {0, -1}}) {
          const int nx = x + dx, ny = y + dy;
          if (!kept(nx, ny) || done[static_cast<std::size_t>(ny * kWidth + nx)]) continue;
          // the jump is taken at the left pixel of a row and at the lower one of a column
          const double z = dx != 0 ? depth(std::min(x, nx), y) : depth(x, std::max(y, ny));
          const double jump = ChangeConfig{}.jump_m + 4 * noise.sigma(z) + 2 * noise.step(z);
          if (std::abs(depth(nx, ny) - depth(x, y)) > jump) continue;
          done[static_cast<std::size_t>(ny * kWidth + nx)] = true;
          open.emplace_back(nx, ny);
        }
      }
    }
  }
  return components;
}

TEST_CASE("components agree with a flood fill on random pictures", "[partner][change]") {
  std::mt19937 random(11);
  auto change = against(wall(3.0F));
  for (int round = 0; round < 40; ++round) {
    auto frame = wall(3.0F);
    for (int i = 0; i < 40; ++i) {
      const int u = static_cast<int>(random() % kWidth), v = static_cast<int>(random() % kHeight);
      paint(frame, u, v, std::min(kWidth, u + 3 + static_cast<int>(random() % 60)),
            std::min(kHeight, v + 3 + static_cast<int>(random() % 20)),
            random() % 7 == 0 ? kNan : 1.0F + 0.25F * static_cast<float>(random() % 8));
    }
    compare(change, frame);
    int flooded = 0;
    const int expected = components_by_flood(change, frame, flooded);
    CHECK(static_cast<int>(change.components().size()) == expected);
    CHECK(pixels(change) == flooded);
  }
}

}  // namespace
}  // namespace colift::perception
