#include <catch2/catch.hpp>

#include "planner/grasp/grasp_candidates.hpp"
#include "seen_scene.hpp"

using namespace colift;
using hal::Vec3;
using planner::CandidateConfig;
using planner::CandidateFinder;
using planner::GraspKind;
using planner::HandModel;
using planner::Verdict;

namespace {

constexpr auto kTarget = sim_hal::Label::Target;

/// A plate of 0.8 x 0.5 m on a post, seen by a camera 35 degrees above the horizon.
sim_hal::SyntheticScene plate() {
  const Vec3 center(0, 0, 0.45), size(0.8, 0.5, 0.025);
  auto scene = tests::scene_of(
      {sim_hal::box(center, size, 0, kTarget), sim_hal::box({0, 0, 0.2}, {0.1, 0.1, 0.43}, 0, kTarget)},
      Vec3(0, -1.5, 0.45 + 0.7 * 1.5), center);
  tests::add_faces(scene, center, size);
  return scene;
}

}  // namespace

TEST_CASE("fingers may reach into the wedge under a near edge", "[unseen]") {
  const auto seen = tests::see(plate(), true);
  const auto found = planner::generate_candidates(seen.scene, HandModel{}, CandidateConfig{}, &seen.cloud);
  int near_edge = 0;
  for (const auto& c : found) {
    if (c.kind != GraspKind::Ega5 || c.verdict == Verdict::TooWide) continue;
    INFO(c.reason);
    CHECK(c.verdict == Verdict::Ok);
    ++near_edge;
  }
  CHECK(near_edge >= 15);
}

TEST_CASE("the far edge hides the lower fingers' way and is refused", "[unseen]") {
  const auto seen = tests::see(plate(), true);
  const auto found = planner::generate_candidates(seen.scene, HandModel{}, CandidateConfig{}, &seen.cloud);
  int far_edge = 0;
  for (const auto& c : found) {
    if (c.kind != GraspKind::Edge || c.approach.y() > -0.9) continue;
    CHECK(c.verdict == Verdict::Collision);
    CHECK_THAT(c.reason, Catch::Contains("unobserved space"));
    ++far_edge;
  }
  CHECK(far_edge >= 5);
}

TEST_CASE("the unseen under the near edge is refused when fingers may not reach into it", "[unseen]") {
  const auto seen = tests::see(plate(), false);
  CandidateConfig config;
  config.collision.max_unseen_m = 0.02;
  const auto found = planner::generate_candidates(seen.scene, HandModel{}, config, &seen.cloud);
  int refused = 0;
  for (const auto& c : found) {
    if (c.kind == GraspKind::Ega5 && c.verdict == Verdict::Collision) {
      CHECK_THAT(c.reason, Catch::Contains("into unobserved space"));
      ++refused;
    }
  }
  CHECK(refused >= 10);
}

TEST_CASE("a strip of a wide box that something else hides is not a narrow face", "[unseen]") {
  // a box face 0.4 m wide; a board before it leaves 3 cm of its right side to see
  const Vec3 center(0, 0, 0.25), size(0.4, 0.4, 0.5);
  auto scene =
      tests::scene_of({sim_hal::box(center, size, 0, kTarget),
                       sim_hal::box({-0.115, -0.45, 0.5}, {0.42, 0.02, 1.0}, 0, sim_hal::Label::Clutter)},
                      {0.1, -1.6, 0.35}, {0.1, 0, 0.3});
  auto seen = tests::see(scene, true);
  perception::Rectangle strip;  // what a segmentation makes of it
  strip.center = {0.185, -0.2, 0.3};
  strip.normal = -Vec3::UnitY();
  strip.u = Vec3::UnitX();
  strip.v = strip.normal.cross(strip.u);
  strip.size = {0.03, 0.3};
  strip.fill = 1.0;
  seen.scene.surfaces = {strip};
  const auto found = planner::generate_candidates(seen.scene, HandModel{}, CandidateConfig{}, &seen.cloud);
  REQUIRE_FALSE(found.empty());
  for (const auto& c : found) {
    INFO(c.reason);
    CHECK(c.verdict == Verdict::Collision);
  }
  const std::string text = planner::explain(found);
  CHECK_THAT(text, Catch::StartsWith("0 of "));
}

TEST_CASE("two faces of a closed box fill what lies behind them", "[unseen]") {
  const Vec3 center(0, 0, 0.2), size(0.5, 0.4, 0.4);
  auto scene = tests::scene_of({sim_hal::box(center, size, 0, kTarget)}, {0.9, -1.3, 1.2}, center);
  tests::add_faces(scene, center, size);
  auto seen = tests::see(scene, false);
  const CandidateFinder finder(seen.scene, &seen.cloud, HandModel{}, CandidateConfig{});
  REQUIRE_FALSE(finder.solids().empty());
  for (const auto& solid : finder.solids()) {
    CHECK(solid.box.center.isApprox(center, 0.02));
    for (const Vec3& axis : {Vec3(Vec3::UnitX()), Vec3(Vec3::UnitY()), Vec3(Vec3::UnitZ())}) {
      CHECK(solid.extent_along(axis) == Approx(size.dot(axis)).margin(0.02));
    }
  }
  // a grasp of a made-up strip in the middle of the top would put fingers into the box
  planner::GraspCandidate c;
  c.kind = GraspKind::Ega5;
  c.position = {0, 0, 0.4};
  c.approach = -Vec3::UnitZ();
  c.closing = Vec3::UnitX();
  c.width = 0.03;
  finder.judge(c);
  CHECK(c.verdict == Verdict::Collision);
}

TEST_CASE("sight tells free, surface, hidden and unknown apart", "[unseen]") {
  hal::DepthFrame frame;
  frame.depth_m.assign(640 * 480, 1.5f);
  const auto nan = std::numeric_limits<float>::quiet_NaN();
  for (int v = 0; v < 480; ++v) {
    for (int u = 0; u < 100; ++u) frame.depth_m[static_cast<std::size_t>(v * 640 + u)] = nan;
    for (int u = 400; u < 420; ++u) frame.depth_m[static_cast<std::size_t>(v * 640 + u)] = nan;
    for (int u = 420; u < 640; ++u) frame.depth_m[static_cast<std::size_t>(v * 640 + u)] = 3.0f;
  }
  const auto cloud = perception::deproject(frame, hal::Pose::Identity());
  const planner::SeenSpace seen(cloud, perception::NoiseModel{}, 3.0, 30);
  const auto at = [&](double u, double z) { return seen.at({(u - 320.0) / 575.8 * z, 0.0, z}); };
  CHECK(at(320, 1.3) == planner::Sight::Free);
  CHECK(at(320, 1.5) == planner::Sight::Surface);
  CHECK(at(320, 1.7) == planner::Sight::Hidden);
  CHECK(at(50, 1.0) == planner::Sight::Unknown);
  CHECK(at(700, 1.0) == planner::Sight::Unknown);
  // the projector's shadow beside an edge: free before the edge's depth, hidden behind it
  CHECK(at(410, 1.3) == planner::Sight::Free);
  CHECK(at(410, 1.7) == planner::Sight::Hidden);
  CHECK(at(500, 1.7) == planner::Sight::Free);
  CHECK(seen.at({0, 0, -1.0}) == planner::Sight::Unknown);
}

TEST_CASE("behind the edge of a panel there is the panel, however thin it is", "[unseen]") {
  // a shelf of two sides and a top, open in front, seen from there; its side is seen by its edge alone
  const Vec3 top(0, 0, 0.59), top_size(0.6, 0.3, 0.02), side(-0.31, 0, 0.3), side_size(0.02, 0.3, 0.6);
  auto scene =
      tests::scene_of({sim_hal::box(top, top_size, 0, kTarget), sim_hal::box(side, side_size, 0, kTarget),
                       sim_hal::box({0.31, 0, 0.3}, side_size, 0, kTarget)},
                      {-0.25, -1.5, 1.5}, {0, 0, 0.3});
  tests::add_faces(scene, top + Vec3(-0.01, 0, 0), top_size + Vec3(0.02, 0, 0));
  tests::add_faces(scene, side, side_size);
  const auto seen = tests::see(scene, true);
  const CandidateFinder finder(seen.scene, &seen.cloud, HandModel{}, {});
  // over the top's short edge, where the side closes it below
  planner::GraspCandidate c;
  c.kind = GraspKind::Edge;
  c.position = {-0.32, 0.0, 0.59};
  c.approach = Vec3::UnitX();
  c.closing = Vec3::UnitZ();
  c.width = 0.02;
  finder.judge(c);
  INFO(c.reason);
  CHECK(c.verdict == Verdict::Collision);
}
