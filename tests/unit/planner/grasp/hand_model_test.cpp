#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <numbers>

#include "planner/hand/hand_model.hpp"
#include "planner/hand/hand_sweep.hpp"

using namespace colift;
using planner::HandModel;

namespace {
constexpr double kDegree = std::numbers::pi / 180.0;
const std::filesystem::path kFile = std::filesystem::path(COLIFT_SOURCE_DIR) / "config/hand/bh8_282.yaml";

std::filesystem::path changed(const std::string& from, const std::string& to, const char* name) {
  std::ifstream in(kFile);
  std::string text((std::istreambuf_iterator<char>(in)), {});
  const auto at = text.find(from);
  REQUIRE(at != std::string::npos);
  text.replace(at, from.size(), to);
  const auto file = std::filesystem::temp_directory_path() / name;
  std::ofstream(file) << text;
  return file;
}
}  // namespace

TEST_CASE("the hand file and the compiled-in hand agree", "[hand]") {
  const auto file = planner::load_hand(kFile);
  REQUIRE(file);
  const HandModel built_in;
  CHECK(file->name == built_in.name);
  CHECK(file->opening_m == built_in.opening_m);
  CHECK(file->palm_gap_m == built_in.palm_gap_m);
  CHECK(file->wrap_gap_m == built_in.wrap_gap_m);
  REQUIRE(file->cuboids.size() == built_in.cuboids.size());
  for (std::size_t i = 0; i < built_in.cuboids.size(); ++i) {
    CHECK(file->cuboids[i].part == built_in.cuboids[i].part);
    CHECK(file->cuboids[i].center_m == built_in.cuboids[i].center_m);
    CHECK(file->cuboids[i].size_m == built_in.cuboids[i].size_m);
  }
  REQUIRE(file->fingers.size() == built_in.fingers.size());
  for (std::size_t i = 0; i < built_in.fingers.size(); ++i) {
    CHECK(file->fingers[i].part == built_in.fingers[i].part);
    CHECK(file->fingers[i].x_m == built_in.fingers[i].x_m);
    CHECK(file->fingers[i].side == built_in.fingers[i].side);
  }
  CHECK(file->finger.joint_radius_m == built_in.finger.joint_radius_m);
  CHECK(file->finger.inner_length_m == built_in.finger.inner_length_m);
  CHECK(file->finger.inner_overhang_m == built_in.finger.inner_overhang_m);
  CHECK(file->finger.inner_width_m == built_in.finger.inner_width_m);
  CHECK(file->finger.outer_length_m == built_in.finger.outer_length_m);
  CHECK(file->finger.outer_width_m == built_in.finger.outer_width_m);
  CHECK(file->finger.half_thickness_m == built_in.finger.half_thickness_m);
  CHECK(file->finger.outer_bend_deg == built_in.finger.outer_bend_deg);
  CHECK(file->finger.coupling == built_in.finger.coupling);
  CHECK(file->finger.open_deg == built_in.finger.open_deg);
  CHECK(file->finger.closed_deg == built_in.finger.closed_deg);
  CHECK(file->pad_width_m == built_in.pad_width_m);
  CHECK(file->pad_height_m == built_in.pad_height_m);
  CHECK(file->finger_force_n == built_in.finger_force_n);
  CHECK(file->finger_hold_n == built_in.finger_hold_n);
  CHECK(file->friction == built_in.friction);
  CHECK(file->min_hold_m == built_in.min_hold_m);
  CHECK(file->wrap_margin_m == built_in.wrap_margin_m);
}

TEST_CASE("a hand that cannot close on anything is refused with its numbers", "[hand]") {
  const auto one_sided =
      planner::load_hand(changed("x_m: 0.0, side: 1", "x_m: 0.0, side: -1", "colift_one_sided.yaml"));
  REQUIRE_FALSE(one_sided);
  CHECK(one_sided.error().code == hal::ErrorCode::BadConfig);
  CHECK_THAT(one_sided.error().detail, Catch::Contains("0 fingers at +Hy and 3 at -Hy"));

  const auto too_open =
      planner::load_hand(changed("opening_m: 0.19", "opening_m: 0.4", "colift_too_open.yaml"));
  REQUIRE_FALSE(too_open);
  CHECK_THAT(too_open.error().detail, Catch::Contains("opening_m is 0.400"));

  const auto misspelt = planner::load_hand(changed("friction:", "frictoin:", "colift_misspelt.yaml"));
  REQUIRE_FALSE(misspelt);
  CHECK_THAT(misspelt.error().text(), Catch::Contains("friction"));
}

TEST_CASE("the fingers move as the maker's table of reach says", "[hand]") {
  HandModel hand;
  hand.finger.outer_length_m = 0.050;  // to the tip's reference point instead of its end
  struct Row {
    double q_deg, tip_radius_mm, tip_height_mm, pad_radius_mm;
  };
  for (const Row& row : {Row{0, 157, 34, 151}, Row{20, 134, 71, 125}, Row{36, 107, 91, 97},
                         Row{50, 79, 101, 70}, Row{70, 38, 101, 32}, Row{90, 2, 86, 0}}) {
    const auto pose = planner::finger_at(hand, hand.fingers[2], row.q_deg * kDegree);
    const auto& o = pose.outer;
    const double tip_y = o.cy + o.h1 * o.ey, tip_z = o.cz + o.h1 * o.ez;
    CHECK(1000 * tip_y == Approx(row.tip_radius_mm).margin(1.0));
    CHECK(1000 * tip_z == Approx(row.tip_height_mm).margin(1.0));
    CHECK(1000 * (tip_y - o.h2 * o.ez) == Approx(row.pad_radius_mm).margin(1.0));
  }
}

TEST_CASE("fingers on both sides mirror each other and meet in the middle", "[hand]") {
  const HandModel hand;
  const auto left = planner::finger_at(hand, hand.fingers[0], 0.7).outer;
  const auto right = planner::finger_at(hand, hand.fingers[2], 0.7).outer;
  CHECK(left.cy == -right.cy);
  CHECK(left.cz == right.cz);
  double before = planner::half_gap_at(hand, 0.0);
  for (double q = 0.05; q < 1.5; q += 0.05) {
    const double now = planner::half_gap_at(hand, q);
    CHECK(now < before);
    before = now;
  }
  const auto contact = planner::contact_at_width(hand, 0.05);
  CHECK(planner::half_gap_at(hand, contact.q_rad) == Approx(0.025).margin(1e-6));
}

TEST_CASE("fingers are stopped where they first meet what is grasped", "[hand]") {
  const HandModel hand;
  planner::GraspCandidate c;
  c.width = 0.05;
  CHECK(planner::stopped_angle(hand, c) == planner::contact_at_width(hand, 0.05).q_rad);

  c.kind = planner::GraspKind::Wrap;
  double before = 10.0;
  for (const double radius : {0.02, 0.03, 0.04, 0.05}) {
    c.width = 2.0 * radius;
    const double q = planner::stopped_angle(hand, c), middle = hand.gap(c) + radius;
    INFO("radius " << radius << ", stopped at " << q);
    CHECK(q < before);
    before = q;
    // no point of the circle is inside a link before, and some is a degree after
    const auto inside = [&](double at) {
      const auto pose = planner::finger_at(hand, hand.fingers[2], at);
      for (double a = 0.0; a < 6.283; a += 0.002) {
        const double y = radius * std::cos(a), z = middle + radius * std::sin(a), x = hand.fingers[2].x_m;
        if (pose.inner.depth(x, y, z) > 0.0 || pose.outer.depth(x, y, z) > 0.0) return true;
      }
      return false;
    };
    CHECK_FALSE(inside(q - 0.02));
    CHECK(inside(q + 0.02));
  }
}

TEST_CASE("the closing stops before the object's width", "[hand]") {
  const HandModel hand;
  const planner::HandSweep sweep(hand, 0.1, 2.0, 0.0);
  for (const double width : {0.005, 0.03, 0.1, 0.19}) {
    const int last = sweep.last_step(width);
    const planner::HandBox* boxes = sweep.finger_boxes(last);
    // outer links; the root of an inner one stays at its knuckle
    for (std::size_t i = 1; i < sweep.links(); i += 2) {
      const planner::HandBox& b = boxes[i];
      const double half = b.h1 * std::abs(b.ey) + b.h2 * std::abs(b.ez);
      CHECK(std::abs(b.cy) - half >= 0.5 * width - 1e-9);
    }
  }
}
