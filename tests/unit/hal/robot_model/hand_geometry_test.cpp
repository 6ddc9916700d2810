#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "hal/robot_model/robot_model.hpp"
#include "planner/hand/hand_model.hpp"

using namespace colift;
using hal::Pose;
using hal::Vec3;

namespace {

const hal::RobotModel& robot() {
  return hal::built_in_robot();
}

/// Pose in H of a link.
Pose in_hand(int link, const hal::HandPosture& hand) {
  std::vector<Pose> X_WL;
  hal::link_poses(robot(), hal::JointVector::Zero(), hand, X_WL);
  return X_WL[static_cast<std::size_t>(robot().palm)].inverse() * X_WL[static_cast<std::size_t>(link)];
}

/// Corners of a link's one box in H.
std::vector<Vec3> corners(int link, const hal::HandPosture& hand) {
  const auto& shapes = robot().links[static_cast<std::size_t>(link)].shapes;
  REQUIRE(shapes.size() == 1);
  REQUIRE(shapes[0].kind == hal::LinkShape::Kind::Box);
  std::vector<Vec3> out;
  for (int i = 0; i < 8; ++i) {
    const Vec3 sign(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1);
    out.emplace_back(in_hand(link, hand) * (shapes[0].X_LS * (0.5 * shapes[0].size.cwiseProduct(sign))));
  }
  return out;
}

double volume(int link) {
  return robot().links[static_cast<std::size_t>(link)].shapes[0].size.prod();
}

/// Every corner of the URDF's box lies on a corner of the planner's box, and both are equally large.
void check_same(const planner::HandBox& box, int link, const hal::HandPosture& hand) {
  CHECK(8.0 * box.hx * box.h1 * box.h2 == Approx(volume(link)).epsilon(1e-6));
  for (const Vec3& p : corners(link, hand)) CHECK(std::abs(box.depth(p.x(), p.y(), p.z())) < 1e-3);
}

int link_named(const std::string& name) {
  for (std::size_t i = 0; i < robot().links.size(); ++i) {
    if (robot().links[i].name == name) return static_cast<int>(i);
  }
  return -1;
}

}  // namespace

TEST_CASE("the fingers of the URDF are those of the planner's hand while they close") {
  const planner::HandModel hand;
  for (int degrees = 0; degrees <= 140; degrees += 5) {
    const double q = degrees * std::numbers::pi / 180.0;
    const hal::HandPosture posture = hal::coupled_posture(q);
    for (std::size_t f = 0; f < hal::kFingers; ++f) {
      CAPTURE(degrees, f);
      const planner::FingerPose pose = planner::finger_at(hand, hand.fingers[f], q);
      check_same(pose.inner, robot().inner[f], posture);
      check_same(pose.outer, robot().outer[f], posture);
    }
  }
}

TEST_CASE("palm and knuckles of the URDF are the cuboids of the planner's hand") {
  const planner::HandModel hand;
  const char* names[] = {"palm", "finger_1_knuckle", "finger_2_knuckle", "finger_3_knuckle"};
  REQUIRE(hand.cuboids.size() == 4);
  for (std::size_t i = 0; i < 4; ++i) {
    CAPTURE(names[i]);
    const planner::HandCuboid& c = hand.cuboids[i];
    const planner::HandBox box{c.center_m.x(),
                               c.center_m.y(),
                               c.center_m.z(),
                               0.5 * c.size_m.x(),
                               0.5 * c.size_m.y(),
                               0.5 * c.size_m.z(),
                               1.0,
                               0.0};
    const int link = link_named(names[i]);
    REQUIRE(link >= 0);
    check_same(box, link, hal::HandPosture{});
  }
}

TEST_CASE("a spread of 180 degrees puts fingers 1 and 2 beside finger 3") {
  hal::HandPosture hand;
  const auto root = [&](std::size_t f) -> Vec3 { return in_hand(robot().inner[f], hand).translation(); };
  CHECK((root(0) - Vec3(-0.025, -0.05, 0)).norm() < 1e-9);
  CHECK((root(1) - Vec3(0.025, -0.05, 0)).norm() < 1e-9);
  CHECK((root(2) - Vec3(0, 0.05, 0)).norm() < 1e-9);
  // half way they point away from each other
  hand.spread_rad = std::numbers::pi / 2;
  CHECK((root(0) - Vec3(-0.075, 0, 0)).norm() < 1e-9);
  CHECK((root(1) - Vec3(0.075, 0, 0)).norm() < 1e-9);
  hand.spread_rad = std::numbers::pi;
  CHECK((root(0) - Vec3(-0.025, 0.05, 0)).norm() < 1e-9);
  CHECK((root(1) - Vec3(0.025, 0.05, 0)).norm() < 1e-9);
  CHECK((root(2) - Vec3(0, 0.05, 0)).norm() < 1e-9);
}

TEST_CASE("fingertips reach as far as the maker's table says") {
  // radius from the palm's axis and height above the finger joints by the DH table with tip (50, 9.5) mm
  const double reach[][3] = {{0, 157, 34},  {20, 134, 71}, {36, 107, 91},
                             {50, 79, 101}, {70, 38, 101}, {90, 2, 86}};
  for (const auto& [degrees, radius_mm, height_mm] : reach) {
    const hal::HandPosture hand = hal::coupled_posture(degrees * std::numbers::pi / 180.0);
    const Vec3 joint = in_hand(robot().outer[2], hand).translation();
    const Vec3 along = in_hand(robot().outer[2], hand).linear().col(0);
    CAPTURE(degrees);
    CHECK(1e3 * (joint + 0.050 * along).y() == Approx(radius_mm).margin(0.6));
    CHECK(1e3 * (joint + 0.050 * along).z() == Approx(height_mm).margin(0.6));
  }
}

TEST_CASE("a hand that reports its joints stands as it reports") {
  hal::HandState state;
  state.finger_rad = {0.1, 0.2, 0.3};
  state.outer_rad = {0.5, 0.6, 0.7};
  state.spread_rad = 0.4;
  const hal::HandPosture posture = hal::posture_of(state);
  CHECK(posture.inner_rad == state.finger_rad);
  CHECK(posture.outer_rad == state.outer_rad);
  CHECK(posture.spread_rad == 0.4);
  CHECK(hal::coupled_posture(0.9, 0.1).outer_rad[1] == Approx(0.3));
  CHECK(hal::coupled_posture(0.9, 0.1).spread_rad == 0.1);
}
