#include "perception/partner/contact_cover.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

namespace colift::perception {
namespace {

constexpr int kWidth = 64, kHeight = 48;
constexpr float kWall = 2.0F, kHand = 1.95F, kBody = 1.2F;

// A camera at the origin of W before a wall; a hand on the wall, 10 x 10 pixels around the middle.
struct View {
  hal::DepthFrame frame;
  OrganisedCloud reference;
  std::vector<std::uint32_t> hand;
  NoiseModel noise;
  HandPixels pixels{HiddenConfig{}};

  View() {
    frame.intrinsics.width = kWidth;
    frame.intrinsics.height = kHeight;
    frame.intrinsics.fx = frame.intrinsics.fy = 300.0;
    frame.intrinsics.cx = 32.0;
    frame.intrinsics.cy = 24.0;
    frame.depth_m.assign(kWidth * kHeight, kWall);
    reference = deproject(frame, hal::Pose::Identity());
    for (int v = 19; v < 29; ++v)
      for (int u = 27; u < 37; ++u) hand.push_back(static_cast<std::uint32_t>(v * kWidth + u));
  }

  hal::DepthFrame with(float depth, std::size_t first, std::size_t last) const {
    hal::DepthFrame f = frame;
    for (std::size_t n = first; n < last; ++n) f.depth_m[hand[n]] = depth;
    return f;
  }
  void show_hand() { pixels.seen(reference, with(kHand, 0, hand.size()), hand, hal::Vec3(0, 0, kHand)); }
  [[nodiscard]] bool hidden(const hal::DepthFrame& f, const std::vector<std::uint32_t>& robot = {}) const {
    return pixels.hidden(reference, f, robot, noise);
  }
};

TEST_CASE("a hand behind its own body is hidden, not gone", "[partner][hidden]") {
  View view;
  view.show_hand();
  CHECK(view.hidden(view.with(kBody, 0, 100)));
  // half of it covered, the rest in the sensor's shadow beside the body
  hal::DepthFrame half = view.with(kBody, 0, 50);
  for (std::size_t n = 50; n < 100; ++n) half.depth_m[view.hand[n]] = NAN;
  CHECK(view.hidden(half));
}

TEST_CASE("a place that shows again what is there without him is not hidden", "[partner][hidden]") {
  View view;
  view.show_hand();
  CHECK_FALSE(view.hidden(view.frame));
  CHECK_FALSE(view.hidden(view.with(kBody, 0, 60)));  // 40 % of it is uncovered
  CHECK(view.hidden(view.with(kBody, 0, 75)));
}

TEST_CASE("a frame without depth hides nothing", "[partner][hidden]") {
  View view;
  view.show_hand();
  CHECK_FALSE(view.hidden(view.with(NAN, 0, 100)));
}

TEST_CASE("the robot before a hand hides it", "[partner][hidden]") {
  View view;
  view.show_hand();
  CHECK(view.hidden(view.with(NAN, 0, 100), view.hand));
}

TEST_CASE("a rim of the hand that flickers is no picture of it", "[partner][hidden]") {
  View view;
  view.show_hand();
  const std::vector<std::uint32_t> rim(view.hand.begin(), view.hand.begin() + 20);
  view.pixels.seen(view.reference, view.with(kHand, 0, 20), rim, hal::Vec3(0, 0, kHand));
  hal::DepthFrame behind = view.frame;  // the rim shows the wall again, the body covers the rest
  for (std::size_t n = 20; n < 100; ++n) behind.depth_m[view.hand[n]] = kBody;
  CHECK(view.hidden(behind));
}

TEST_CASE("of a hand that was never seen nothing is known", "[partner][hidden]") {
  View view;
  CHECK_FALSE(view.hidden(view.with(kBody, 0, 100)));
  view.show_hand();
  view.pixels.forget();
  CHECK_FALSE(view.hidden(view.with(kBody, 0, 100)));
}

TEST_CASE("a body far from the contact is not the hand", "[partner][hidden]") {
  View view;
  view.pixels.seen(view.reference, view.with(kBody, 0, 100), view.hand, hal::Vec3(0, 0, kHand));
  CHECK_FALSE(view.hidden(view.with(kBody, 0, 100)));
}

TEST_CASE("a frame of another size, and pixels beyond the image, are refused quietly", "[partner][hidden]") {
  View view;
  view.hand.push_back(kWidth * kHeight + 7);
  view.pixels.seen(view.reference, view.with(kHand, 0, 100), view.hand, hal::Vec3(0, 0, kHand));
  hal::DepthFrame small = view.frame;
  small.depth_m.resize(10);
  CHECK_FALSE(view.hidden(small));
}

}  // namespace
}  // namespace colift::perception
