// Bars, legs and handles: how deep a body is behind the face that is grasped.
#include "planner/grasp/body_depth.hpp"

#include <algorithm>
#include <catch2/catch.hpp>

#include "planner/grasp/grasp_candidates.hpp"
#include "seen_scene.hpp"

using namespace colift;
using hal::Vec3;
using planner::CandidateConfig;
using planner::CandidateFinder;
using planner::GraspCandidate;
using planner::GraspKind;
using planner::HandModel;
using planner::Verdict;

namespace {

constexpr auto kTarget = sim_hal::Label::Target;
constexpr double kBar_m = 0.03;

/// A bar of 0.5 m over two thick posts, 0.5 m up.
sim_hal::SyntheticScene bar_on_posts() {
  const Vec3 center(0, 0, 0.5), size(0.5, kBar_m, kBar_m);
  auto scene = tests::scene_of(
      {sim_hal::box(center, size, 0, kTarget), sim_hal::box({-0.25, 0, 0.24}, {0.05, 0.05, 0.48}, 0, kTarget),
       sim_hal::box({0.25, 0, 0.24}, {0.05, 0.05, 0.48}, 0, kTarget)},
      {0.2, -1.3, 1.2}, center);
  tests::add_faces(scene, center, size);
  return scene;
}

const planner::GraspLine* line_towards(const std::vector<planner::GraspLine>& lines, const Vec3& approach) {
  for (const auto& line : lines)
    if (line.kind == GraspKind::Ega5 && line.approach.dot(approach) > 0.95 && line.length() > 0.3)
      return &line;
  return nullptr;
}

}  // namespace

TEST_CASE("of a bar its depth is measured, and the pads press on it instead of behind it", "[bar]") {
  const bool noise = GENERATE(false, true);
  const auto seen = tests::see(bar_on_posts(), noise);
  const HandModel hand;
  const CandidateFinder finder(seen.scene, &seen.cloud, hand, {});
  const auto* front = line_towards(finder.lines(), Vec3::UnitY());
  REQUIRE(front);
  REQUIRE(front->depth);
  CHECK(*front->depth == Approx(kBar_m).margin(0.012));
  int on_bar = 0;
  for (const GraspCandidate& c : finder.find()) {
    if (c.kind != GraspKind::Ega5 || c.verdict != Verdict::Ok || c.approach.y() < 0.95) continue;
    INFO(c.id << " at " << c.depth_m);
    CHECK(c.depth_m > 0.25 * kBar_m);
    CHECK(c.depth_m < 0.75 * kBar_m);
    ++on_bar;
  }
  CHECK(on_bar >= 3);
}

TEST_CASE("pads press a tube at its middle or behind it, where the camera sees past its sides only",
          "[bar]") {
  // a face is found behind the front of a tube and wider than it; the figures are those of a lost grip
  constexpr double kRadius_m = 0.013, kFace_m = 0.0103, kWide_m = 0.032;
  const Vec3 center(0, 0, 0.5), axis = Vec3(0.61, 0.12, 0.78).normalized();
  const Vec3 approach = Vec3(0.34, 0.85, -0.4).cross(axis).cross(-axis).normalized();
  const auto scene = tests::scene_of({sim_hal::cylinder(center, axis, kRadius_m, 0.5, kTarget)},
                                     center + Vec3(0.2, -1.25, 1.21), center);
  auto seen = tests::see(scene, false);
  perception::Rectangle face;
  face.center = center - kFace_m * approach;
  face.normal = -approach, face.u = axis, face.v = face.normal.cross(axis);
  face.size = {0.48, kWide_m};
  face.fill = 1.0;
  seen.scene.surfaces = {face};
  const CandidateFinder finder(seen.scene, &seen.cloud, HandModel{}, {});
  const auto* front = line_towards(finder.lines(), approach);
  REQUIRE(front);
  REQUIRE(front->depth);
  const double pads_m = 0.5 * *front->depth;  // behind the face
  CHECK(pads_m > kFace_m);
  CHECK(pads_m < kFace_m + kRadius_m);
}

TEST_CASE("a bar is grasped from sides too that show no face", "[bar]") {
  auto seen = tests::see(bar_on_posts(), true);
  // at a camera's distance one rectangle stands for the whole bar
  std::erase_if(seen.scene.surfaces,
                [](const auto& s) { return std::get<perception::Rectangle>(s).normal.y() > -0.9; });
  REQUIRE(seen.scene.surfaces.size() == 1);
  const CandidateFinder finder(seen.scene, &seen.cloud, HandModel{}, {});
  const auto sides = planner::bar_lines(finder.lines(), Vec3::UnitZ(), 0.06);
  const auto* above = line_towards(sides, -Vec3::UnitZ());
  REQUIRE(above);
  CHECK(above->from.z() == Approx(0.5 + 0.5 * kBar_m).margin(0.012));
  CHECK(line_towards(sides, Vec3::UnitZ()));
  CHECK(planner::bar_lines(finder.lines(), Vec3::UnitZ(), 0.0).empty());
  // where few are in reach they are candidates too
  const auto more = finder.between(finder.config().step_m, finder.find());
  CHECK(std::any_of(more.begin(), more.end(), [](const auto& c) { return c.approach.z() < -0.95; }));
}

TEST_CASE("a post that hides all behind it is as deep as the side of it that is seen", "[bar]") {
  const Vec3 center(0, 0, 0.4), size(0.05, kBar_m, 0.7);
  const auto label = sim_hal::Label::Target;
  auto scene = tests::scene_of(
      {sim_hal::box(center, size, 0, label), sim_hal::box({0.4, 0, 0.4}, {0.05, kBar_m, 0.7}, 0, label)},
      {1.35, -1.35, 1.5}, center);
  tests::add_faces(scene, center, size);
  const auto seen = tests::see(scene, true);
  const CandidateFinder finder(seen.scene, &seen.cloud, HandModel{}, {});
  const auto* front = line_towards(finder.lines(), Vec3::UnitY());
  REQUIRE(front);
  REQUIRE(front->depth);
  CHECK(*front->depth == Approx(kBar_m).margin(0.012));
}

TEST_CASE("a plate goes on behind its rim: the fingers reach as deep as they can", "[bar]") {
  const Vec3 center(0, 0, 0.45), size(0.8, 0.5, 0.025);
  auto scene = tests::scene_of({sim_hal::box(center, size, 0, kTarget)}, {0, -1.5, 1.5}, center);
  tests::add_faces(scene, center, size);
  const auto seen = tests::see(scene, true);
  const CandidateFinder finder(seen.scene, &seen.cloud, HandModel{}, {});
  const auto* rim = line_towards(finder.lines(), Vec3::UnitY());
  REQUIRE(rim);
  CHECK_FALSE(rim->depth);
  const GraspCandidate* found = nullptr;
  const auto candidates = finder.find();
  for (const GraspCandidate& c : candidates)
    if (c.kind == GraspKind::Ega5 && c.verdict == Verdict::Ok && c.approach.y() > 0.95) found = &c;
  REQUIRE(found);
  CHECK_FALSE(found->gap_m);
}

TEST_CASE("candidates between the others are new ones", "[bar]") {
  const auto seen = tests::see(bar_on_posts(), true);
  const CandidateFinder finder(seen.scene, &seen.cloud, HandModel{}, {});
  const auto coarse = finder.find();
  const double step = 0.5 * finder.config().step_m;
  const auto fine = finder.between(step, coarse);
  REQUIRE_FALSE(fine.empty());
  CHECK(fine.front().id == coarse.back().id + 1);
  for (const GraspCandidate& c : fine)
    for (const GraspCandidate& known : coarse) {
      if (known.verdict == Verdict::TooWide || known.approach.dot(c.approach) < 0.999) continue;
      if (std::abs(known.closing.dot(c.closing)) < 0.999) continue;
      CHECK((known.position - c.position).norm() > 0.45 * step);
    }
  std::vector<GraspCandidate> all = coarse;
  all.insert(all.end(), fine.begin(), fine.end());
  CHECK(finder.between(step, all).empty());
}

TEST_CASE("where a finger would meet what is behind a handle, the hand reaches less far", "[bar]") {
  const Vec3 center(0, 0, 0.5), size(0.17, 0.022, 0.018);
  auto scene = tests::scene_of(
      {sim_hal::box(center, size, 0, kTarget), sim_hal::box({0, 0.133, 0.35}, {0.6, 0.2, 0.5}, 0, kTarget)},
      {0.1, -1.3, 1.1}, center);
  tests::add_faces(scene, center, size);
  const auto seen = tests::see(scene, false);
  const HandModel hand;
  const auto free_from_front = [&](double max_pull_back_m) {
    CandidateConfig config;
    config.max_pull_back_m = max_pull_back_m;
    const auto all = CandidateFinder(seen.scene, &seen.cloud, hand, config).find();
    return std::count_if(all.begin(), all.end(), [](const GraspCandidate& c) {
      return c.verdict == Verdict::Ok && c.approach.y() > 0.95;
    });
  };
  CHECK(free_from_front(0.0) == 0);
  CHECK(free_from_front(0.015) >= 3);
}
