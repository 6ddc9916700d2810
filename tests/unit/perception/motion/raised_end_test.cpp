#include "perception/motion/raised_end.hpp"

#include <catch2/catch.hpp>
#include <optional>

namespace colift::perception {
namespace {

using namespace std::chrono_literals;

const Vec3 kEdge_W(1.5, 0.1, 0.7);

// A table that turns about its near feet, which stand 0.8 m from its far edge; one frame follows the other in
// 33 ms.
struct Table {
  RaiseConfig config;
  RaisedEnd end{config};
  hal::Timestamp now{0};
  double noise_m = 0.0003;

  std::optional<RaisedEnd::Grasp> see(double rise_m, const Vec3& aside_m = Vec3::Zero(),
                                      const Vec3& edge_W = kEdge_W) {
    now += 33ms;
    PartnerGrasp hidden;
    hidden.position = edge_W;
    hidden.covariance = 0.08 * 0.08 * Eigen::Matrix3d::Identity();
    ObjectMotion motion;
    motion.X_WTnow_WTref.translation() = aside_m + rise_m * Vec3::UnitZ();
    motion.covariance.topLeftCorner<3, 3>() = noise_m * noise_m * Eigen::Matrix3d::Identity();
    motion.center_W = Vec3(1.1, 0.1, 0.6);
    return end.update(now, hidden, motion, Vec3::UnitZ());
  }
  std::optional<RaisedEnd::Grasp> see_frames(int n, double rise_m, const Vec3& aside_m = Vec3::Zero()) {
    std::optional<RaisedEnd::Grasp> out;
    for (int k = 0; k < n; ++k)
      if (auto grasp = see(rise_m, aside_m)) out = grasp;
    return out;
  }
};

TEST_CASE("who raises his end behind his back, and puts it down, holds it", "[motion][hidden]") {
  Table table;
  CHECK_FALSE(table.see_frames(20, 0.001));  // what the follower says of an object at rest
  CHECK_FALSE(table.see_frames(10, 0.009));
  CHECK(table.end.raised());
  CHECK(table.end.rise_m() == Approx(0.008));
  const auto held = table.see_frames(12, 0.0012);
  REQUIRE(held);
  CHECK(held->rise_m == Approx(0.008));
  CHECK(held->grasp.position.isApprox(kEdge_W));
  CHECK_FALSE(table.see_frames(30, 0.001));  // once
}

TEST_CASE("an end that stays up is no grasp yet", "[motion][hidden]") {
  Table table;
  table.see_frames(20, 0.0);
  CHECK_FALSE(table.see_frames(100, 0.008));
  CHECK_FALSE(table.see_frames(5, 0.0));  // it has to stand for a moment
  CHECK(table.see_frames(10, 0.0));
  CHECK_FALSE(table.see_frames(20, 0.0));
  CHECK_FALSE(table.see_frames(400, 0.008));  // something was pushed under it
  CHECK_FALSE(table.end.raised());
}

TEST_CASE("an end that comes down a little higher than it stood, stands", "[motion][hidden]") {
  Table table;
  table.see_frames(20, 0.0);
  table.see_frames(10, 0.010);
  CHECK(table.see_frames(12, 0.002));
}

TEST_CASE("half a rise that stays is how it stands now", "[motion][hidden]") {
  Table table;
  table.see_frames(20, 0.0);
  table.see_frames(10, 0.002);
  CHECK(table.end.moves());
  table.see_frames(150, 0.002);
  CHECK_FALSE(table.end.moves());
  table.see_frames(10, 0.008);
  CHECK(table.see_frames(12, 0.002));
}

TEST_CASE("a push from the side is none", "[motion][hidden]") {
  Table table;
  table.see_frames(20, 0.0);
  CHECK_FALSE(table.see_frames(20, 0.0, 0.02 * Vec3::UnitX()));
  CHECK_FALSE(table.see_frames(20, 0.0));
}

TEST_CASE("a rise that is within the noise, or of a frame or two, is none", "[motion][hidden]") {
  Table noisy;  // his outline changes, and with it what is seen of the object
  for (int k = 0; k < 40; ++k) noisy.see(k % 2 ? 0.003 : -0.003);
  for (int k = 0; k < 10; ++k) CHECK_FALSE(noisy.see(k % 2 ? 0.009 : 0.006));
  CHECK_FALSE(noisy.see_frames(20, 0.0));
  Table unsure;  // what the view does not hold
  unsure.noise_m = ObjectMotion::kUnknown;
  unsure.see_frames(20, 0.0);
  CHECK_FALSE(unsure.see_frames(10, 0.008));
  CHECK_FALSE(unsure.see_frames(20, 0.0));
  Table flicker;
  flicker.see_frames(20, 0.0);
  for (int k = 0; k < 10; ++k) {
    CHECK_FALSE(flicker.see_frames(flicker.config.frames - 1, 0.008));
    CHECK_FALSE(flicker.see_frames(15, 0.0));
  }
}

TEST_CASE("an object that was raised before anybody hid it stands as it does", "[motion][hidden]") {
  Table table;
  CHECK_FALSE(table.see_frames(30, 0.01));
  CHECK_FALSE(table.see_frames(30, 0.01));
  CHECK_FALSE(table.end.raised());
}

TEST_CASE("a slow drift of what the camera says is no rise", "[motion][hidden]") {
  Table table;
  for (int k = 0; k < 300; ++k) CHECK_FALSE(table.see(2e-5 * k));
  CHECK_FALSE(table.end.raised());
}

}  // namespace
}  // namespace colift::perception
