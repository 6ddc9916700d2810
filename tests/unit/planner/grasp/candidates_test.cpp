#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <set>

#include "planner/grasp/grasp_candidates.hpp"
#include "planner/hand/leg_face.hpp"
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

/// A table of 0.8 x 0.5 x 0.45 m with a top of 25 mm, seen from a corner.
sim_hal::SyntheticScene table() {
  const Vec3 center(0, 0, 0.4375), size(0.8, 0.5, 0.025);
  std::vector<sim_hal::Shape> shapes{sim_hal::box(center, size, 0.0, kTarget)};
  for (const double sx : {-1.0, 1.0}) {
    for (const double sy : {-1.0, 1.0}) {
      shapes.push_back(sim_hal::box({sx * 0.33, sy * 0.18, 0.2125}, {0.04, 0.04, 0.425}, 0.0, kTarget));
    }
  }
  auto scene = tests::scene_of(shapes, {0.9, -1.3, 1.4}, {0, 0, 0.35});
  tests::add_faces(scene, center, size);
  return scene;
}

sim_hal::SyntheticScene pipe_on_floor(double radius) {
  auto scene = tests::scene_of({sim_hal::cylinder({0, 0, radius}, Vec3::UnitX(), radius, 1.0, kTarget)},
                               {0.3, -1.3, 1.1}, {0, 0, 0.05});
  scene.cylinders.push_back({{0, 0, radius}, Vec3::UnitX(), radius, 1.0});
  return scene;
}

sim_hal::SyntheticScene open_box() {
  // 0.5 x 0.4 x 0.3 m with walls of 15 mm
  const double w = 0.015;
  auto scene = tests::scene_of({sim_hal::box({0, -0.2 + w / 2, 0.15}, {0.5, w, 0.3}, 0, kTarget),
                                sim_hal::box({0, 0.2 - w / 2, 0.15}, {0.5, w, 0.3}, 0, kTarget),
                                sim_hal::box({-0.25 + w / 2, 0, 0.15}, {w, 0.4 - 2 * w, 0.3}, 0, kTarget),
                                sim_hal::box({0.25 - w / 2, 0, 0.15}, {w, 0.4 - 2 * w, 0.3}, 0, kTarget),
                                sim_hal::box({0, 0, w / 2}, {0.5 - 2 * w, 0.4 - 2 * w, w}, 0, kTarget)},
                               {0.4, -1.2, 1.2}, {0, 0, 0.15});
  // walls as a segmentation sees them: large faces only, the rims of 15 mm are left to the edge grasps
  const auto face = [&](const Vec3& center, const Vec3& normal, double width, double height) {
    const Vec3 u = Vec3::UnitZ().cross(normal);
    scene.faces.push_back({center, normal, u, Vec3::UnitZ(), width, height});
  };
  face({0, -0.2, 0.15}, -Vec3::UnitY(), 0.5, 0.3);
  face({0.25, 0, 0.15}, Vec3::UnitX(), 0.4, 0.3);
  face({0, 0.2 - w, 0.15}, -Vec3::UnitY(), 0.5 - 2 * w, 0.3);
  face({-0.25 + w, 0, 0.15}, Vec3::UnitX(), 0.4 - 2 * w, 0.3);
  return scene;
}

/// A seat of 30 mm on legs that are flush with its edges, seen from the side: the leg's face goes on from the
/// seat's own edge face.
sim_hal::SyntheticScene seat_on_legs() {
  const Vec3 center(0, 0, 0.385), size(0.44, 0.42, 0.03);
  std::vector<sim_hal::Shape> shapes{sim_hal::box(center, size, 0.0, kTarget)};
  for (const double x : {-0.2025, 0.2025})
    for (const double y : {-0.1925, 0.1925})
      shapes.push_back(sim_hal::box({x, y, 0.185}, {0.035, 0.035, 0.37}, 0.0, kTarget));
  auto scene = tests::scene_of(shapes, {1.7, 0.19, 1.2}, {0, 0, 0.3});
  const auto face = [&](const Vec3& middle, const Vec3& normal, const Vec3& u, double width, double height) {
    scene.faces.push_back({middle, normal, u, normal.cross(u), width, height});
  };
  face({0, 0, 0.40}, Vec3::UnitZ(), Vec3::UnitX(), 0.44, 0.42);
  face({0.22, -0.02, 0.385}, Vec3::UnitX(), Vec3::UnitY(), 0.37, 0.03);
  face({0.22, 0.1925, 0.20}, Vec3::UnitX(), Vec3::UnitY(), 0.035, 0.40);
  return scene;
}

int count(const std::vector<GraspCandidate>& list, GraspKind kind, Verdict verdict) {
  return static_cast<int>(std::count_if(list.begin(), list.end(), [&](const GraspCandidate& c) {
    return c.kind == kind && c.verdict == verdict;
  }));
}

}  // namespace

TEST_CASE("a table offers its visible edge faces, and only the legs behind them are in the way",
          "[candidates]") {
  for (const bool noise : {false, true}) {
    const auto seen = tests::see(table(), noise);
    const CandidateFinder finder(seen.scene, &seen.cloud, HandModel{}, CandidateConfig{});
    const auto found = finder.find();
    std::set<int> faces;
    for (const auto& c : found) {
      if (c.kind != GraspKind::Ega5 || c.verdict == Verdict::TooWide) continue;
      INFO("noise " << noise << ", " << c.position.transpose() << ": " << c.reason);
      // legs stand 5 cm behind the edges, 33 and 18 cm from the middle; the fingers are 8 cm wide together
      const bool front = c.approach.y() > 0.9;
      const double to_leg =
          std::abs(front ? std::abs(c.position.x()) - 0.33 : std::abs(c.position.y()) - 0.18);
      if (to_leg > 0.065) CHECK(c.verdict == Verdict::Ok);
      if (to_leg < 0.01) CHECK(c.verdict == Verdict::Collision);
      CHECK(c.width == Approx(0.025).margin(0.004));
      CHECK(std::abs(c.closing.z()) == Approx(1.0));
      faces.insert(c.surface);
    }
    // towards the camera: -y and +x
    CHECK(faces.size() == 2);
    CHECK(count(found, GraspKind::Ega5, Verdict::TooWide) == 1);
  }
}

TEST_CASE("candidates lie at most a step apart, end to end, with ids in order", "[candidates]") {
  const auto seen = tests::see(table(), false);
  const auto found = planner::generate_candidates(seen.scene, HandModel{}, CandidateConfig{}, &seen.cloud);
  for (std::size_t i = 0; i < found.size(); ++i) CHECK(found[i].id == static_cast<int>(i));
  std::vector<double> x;
  for (const auto& c : found) {
    if (c.kind == GraspKind::Ega5 && c.verdict != Verdict::TooWide && c.approach.y() > 0.9)
      x.push_back(c.position.x());
  }
  std::sort(x.begin(), x.end());
  REQUIRE(x.size() >= 15);
  CHECK(x.front() == Approx(-0.36).margin(0.01));
  CHECK(x.back() == Approx(0.36).margin(0.01));
  for (std::size_t i = 1; i < x.size(); ++i) CHECK(x[i] - x[i - 1] <= 0.05 + 1e-9);
}

TEST_CASE("a finer step gives more candidates", "[candidates]") {
  const auto seen = tests::see(table(), false);
  CandidateConfig fine;
  fine.step_m = 0.02;
  CHECK(planner::generate_candidates(seen.scene, HandModel{}, fine, &seen.cloud).size() >
        2 * planner::generate_candidates(seen.scene, HandModel{}, CandidateConfig{}, &seen.cloud).size() -
            10);
}

TEST_CASE("a box wider than the opening is too wide on every face, with the numbers", "[candidates]") {
  const Vec3 center(0, 0, 0.2), size(0.5, 0.4, 0.4);
  auto scene = tests::scene_of({sim_hal::box(center, size, 0, kTarget)}, {0.8, -1.3, 1.3}, center);
  tests::add_faces(scene, center, size);
  const auto seen = tests::see(scene, true);
  const auto found = planner::generate_candidates(seen.scene, HandModel{}, CandidateConfig{}, &seen.cloud);
  REQUIRE(found.size() == 3);
  for (const auto& c : found) {
    CHECK(c.verdict == Verdict::TooWide);
    CHECK_THAT(c.reason, Catch::Contains("the hand opens 190 mm"));
  }
  const std::string text = planner::explain(found);
  CHECK_THAT(text, Catch::StartsWith("0 of 3 candidates are free: 3 too wide"));
  CHECK_THAT(text, Catch::Contains("nearest miss"));
}

TEST_CASE("a small box can be closed on both ways", "[candidates]") {
  const Vec3 center(0, 0, 0.2), size(0.15, 0.12, 0.4);
  auto scene = tests::scene_of({sim_hal::box(center, size, 0, kTarget)}, {0.5, -1.2, 1.2}, center);
  tests::add_faces(scene, center, size);
  const auto seen = tests::see(scene, false);
  const auto found = planner::generate_candidates(seen.scene, HandModel{}, CandidateConfig{}, &seen.cloud);
  bool along_x = false, along_y = false;
  for (const auto& c : found) {
    if (c.approach.z() > -0.9 || c.verdict != Verdict::Ok) continue;
    along_x |= std::abs(c.closing.x()) > 0.9;
    along_y |= std::abs(c.closing.y()) > 0.9;
  }
  CHECK(along_x);
  CHECK(along_y);
}

TEST_CASE("the rim of an open box is taken from above", "[candidates]") {
  const auto seen = tests::see(open_box(), true);
  const CandidateFinder finder(seen.scene, &seen.cloud, HandModel{}, CandidateConfig{});
  const auto found = finder.find();
  int from_above = 0, far_wall = 0;
  for (const auto& c : found) {
    if (c.kind != GraspKind::Edge || c.verdict != Verdict::Ok) continue;
    if (c.approach.z() > -0.99) continue;
    CHECK(std::abs(c.closing.z()) < 0.01);
    CHECK(c.position.z() == Approx(0.3).margin(0.01));
    ++from_above;
    if (c.position.y() > 0.1) ++far_wall;
  }
  INFO(planner::explain(found));
  CHECK(from_above >= 8);
  CHECK(far_wall >= 3);
  // the walls do not imply a full box: the camera looked into it
  for (const auto& solid : finder.solids()) CHECK(solid.box.size.minCoeff() < 0.05);
}

TEST_CASE("a thickness that was not seen is assumed and said so", "[candidates]") {
  const auto seen = tests::see(open_box(), false);
  const CandidateFinder finder(seen.scene, &seen.cloud, HandModel{}, CandidateConfig{});
  for (const auto& line : finder.lines()) {
    if (line.kind == GraspKind::Edge) CHECK_THAT(line.note, Catch::StartsWith("thickness"));
  }
}

TEST_CASE("a leg's face that goes on from a seat's edge does not make the seat thick", "[candidates]") {
  const auto seen = tests::see(seat_on_legs(), false);
  const CandidateFinder finder(seen.scene, &seen.cloud, HandModel{}, CandidateConfig{});
  REQUIRE(std::any_of(finder.solids().begin(), finder.solids().end(),
                      [](const auto& solid) { return solid.extent_along(Vec3::UnitZ()) > 0.3; }));
  int rims = 0;
  for (const auto& line : finder.lines()) {
    if (line.kind != GraspKind::Edge || std::abs(line.approach.z()) > 0.1) continue;
    ++rims;
    CHECK(line.width == Approx(0.03).margin(0.01));
  }
  CHECK(rims > 0);
}

TEST_CASE("a leg's face under an edge fills a leg, not a wall under the whole seat", "[candidates]") {
  const auto seen = tests::see(seat_on_legs(), false);
  const CandidateFinder finder(seen.scene, &seen.cloud, HandModel{}, CandidateConfig{});
  const perception::Rectangle* seat = nullptr;
  for (const auto& s : seen.scene.surfaces) {
    const auto& r = std::get<perception::Rectangle>(s);
    if (r.normal.z() > 0.9) seat = &r;
  }
  REQUIRE(seat != nullptr);
  int legs = 0, rims = 0;
  for (const auto& s : seen.scene.surfaces) {
    const auto& r = std::get<perception::Rectangle>(s);
    if (r.normal.z() > 0.9) continue;
    const bool leg = planner::extent_of(r, Vec3::UnitZ()).length() > 0.1;
    (leg ? legs : rims) += 1;
    CHECK(planner::is_leg_face(r, *seat, *finder.seen()) == leg);
  }
  CHECK(legs > 0);
  CHECK(rims > 0);
  for (const auto& solid : finder.solids()) {
    if (solid.extent_along(Vec3::UnitZ()) > 0.1) CHECK(solid.extent_along(Vec3::UnitX()) < 0.06);
  }
}

TEST_CASE("an edge grasp does not repeat the grasp of a face at the same rim", "[candidates]") {
  const auto seen = tests::see(table(), false);
  const auto found = planner::generate_candidates(seen.scene, HandModel{}, CandidateConfig{}, &seen.cloud);
  for (const auto& e : found) {
    if (e.kind != GraspKind::Edge) continue;
    for (const auto& f : found) {
      if (f.kind != GraspKind::Ega5 || f.verdict == Verdict::TooWide || f.approach.dot(e.approach) < 0.866)
        continue;
      CHECK((e.position - f.position).norm() > 0.025);
    }
  }
}

TEST_CASE("a pipe on the floor is wrapped from above and not from below", "[candidates]") {
  const auto seen = tests::see(pipe_on_floor(0.04), true);
  const CandidateFinder finder(seen.scene, &seen.cloud, HandModel{}, CandidateConfig{});
  const auto found = finder.find();
  CHECK(count(found, GraspKind::Wrap, Verdict::Ok) >= 10);
  for (const auto& c : found) {
    if (c.verdict != Verdict::Ok) continue;
    CHECK(c.approach.z() < 0.0);
    CHECK(std::abs(c.closing.x()) < 1e-6);
    CHECK(c.width == Approx(0.08));
  }
  GraspCandidate below;
  below.kind = GraspKind::Wrap;
  below.position = Vec3::Zero();
  below.approach = Vec3::UnitZ();
  below.closing = Vec3::UnitY();
  below.width = 0.08;
  finder.judge(below);
  CHECK(below.verdict == Verdict::Collision);
  CHECK_THAT(below.reason, Catch::Contains("the ground"));
}

TEST_CASE("a pipe thicker than the opening is too wide", "[candidates]") {
  const auto seen = tests::see(pipe_on_floor(0.12), false);
  const auto found = planner::generate_candidates(seen.scene, HandModel{}, CandidateConfig{}, &seen.cloud);
  REQUIRE(found.size() == 1);
  CHECK(found[0].reason == "the cylinder is 240 mm thick, the hand opens 190 mm");
}

TEST_CASE("a candidate near a point lies at the foot on its line and is not repeated", "[candidates]") {
  const auto seen = tests::see(table(), false);
  const CandidateFinder finder(seen.scene, &seen.cloud, HandModel{}, CandidateConfig{});
  const auto all = finder.find();
  const Vec3 request(0.117, -0.3, 0.4375);
  const auto extra = finder.near(request, all);
  REQUIRE_FALSE(extra.empty());
  CHECK(extra[0].position.x() == Approx(0.117).margin(1e-6));
  CHECK(extra[0].id == static_cast<int>(all.size()));
  CHECK(extra[0].verdict == Verdict::Ok);
  auto both = all;
  both.insert(both.end(), extra.begin(), extra.end());
  for (const auto& again : finder.near(request, both)) {
    for (const auto& c : both) {
      const bool same = (c.position - again.position).norm() < 0.002 &&
                        c.approach.dot(again.approach) > 0.999 &&
                        std::abs(c.closing.dot(again.closing)) > 0.999 && c.gap_m == again.gap_m &&
                        c.verdict != Verdict::TooWide;
      CHECK_FALSE(same);
    }
  }
}

TEST_CASE("around a candidate there are others on its line, up to its neighbours", "[candidates]") {
  const auto seen = tests::see(table(), false);
  CandidateConfig config;
  const CandidateFinder finder(seen.scene, &seen.cloud, HandModel{}, config);
  auto all = finder.find();
  const auto chosen =
      std::find_if(all.begin(), all.end(), [](const auto& c) { return c.verdict == Verdict::Ok; });
  REQUIRE(chosen != all.end());
  const GraspCandidate best = *chosen;
  const auto more = finder.around(best, all);
  REQUIRE_FALSE(more.empty());
  CHECK(more.size() <= 2 * static_cast<std::size_t>(config.refine_steps));
  int id = static_cast<int>(all.size());
  for (const auto& c : more) {
    const double away_m = (c.position - best.position).norm();
    CHECK(away_m > 0.25 * config.step_m - 1e-6);
    CHECK(away_m < config.step_m);
    CHECK(c.approach.dot(best.approach) > 0.999);
    CHECK(c.surface == best.surface);
    CHECK(c.id == id++);
  }
  all.insert(all.end(), more.begin(), more.end());
  CHECK(finder.around(best, all).empty());
  const auto turned = finder.turned(best, 0.3);
  REQUIRE(turned);
  CHECK(finder.around(*turned, all).empty());
  config.refine_steps = 0;
  CHECK(CandidateFinder(seen.scene, &seen.cloud, HandModel{}, config).around(best, {}).empty());
}

TEST_CASE("a hand comes at an angle to a rim with its pads parallel to the plate", "[candidates]") {
  const auto seen = tests::see(table(), false);
  const CandidateFinder finder(seen.scene, &seen.cloud, HandModel{}, CandidateConfig{});
  int turned = 0;
  for (const auto& c : finder.find()) {
    if (c.verdict != Verdict::Ok) continue;
    for (const double angle : {-0.6, -0.3, 0.3, 0.6}) {
      const auto other = finder.turned(c, angle);
      REQUIRE(other);
      turned += other->verdict == Verdict::Ok;
      CHECK((other->position - c.position).norm() == 0.0);
      CHECK(other->approach.dot(c.approach) == Approx(std::cos(angle)));
      CHECK(std::abs(other->approach.dot(other->closing)) < 1e-9);
      // no corner of the palm in the plate
      CHECK(HandModel{}.gap(*other) * std::cos(angle) > 0.0445 * std::sin(std::abs(angle)));
    }
    CHECK_FALSE(finder.turned(c, 1.3));
  }
  CHECK(turned > 0);
}

TEST_CASE("where the load is wanted nearer to the face the hand stays farther out", "[candidates]") {
  const auto seen = tests::see(table(), false);
  const CandidateFinder finder(seen.scene, &seen.cloud, HandModel{}, CandidateConfig{});
  const Vec3 outside(0.117, -0.35, 0.4375), inside(0.117, -0.1, 0.4375);
  const auto shallowest = [](const std::vector<GraspCandidate>& found) {
    double depth = 1.0;
    for (const auto& c : found) depth = std::min(depth, c.depth_m);
    return depth;
  };
  const auto all = finder.find();
  CHECK(shallowest(finder.near(outside, all)) == Approx(0.03));
  CHECK(shallowest(finder.near(inside, all)) > 0.04);
}

TEST_CASE("the thesis's candidates are rectangles only and all of them stable", "[candidates]") {
  const auto seen = tests::see(pipe_on_floor(0.04), false);
  CHECK(planner::generate_candidates(seen.scene, HandModel{}, planner::thesis_candidates()).empty());
  const auto table_seen = tests::see(table(), false);
  const auto found =
      planner::generate_candidates(table_seen.scene, HandModel{}, planner::thesis_candidates());
  CHECK(count(found, GraspKind::Ega5, Verdict::Ok) > 10);
  for (const auto& c : found) CHECK_FALSE(c.stability.has_value());
}

TEST_CASE("no target, no candidates, and a sentence all the same", "[candidates]") {
  const auto found = planner::generate_candidates(perception::Scene{}, HandModel{}, CandidateConfig{});
  CHECK(found.empty());
  CHECK_THAT(planner::explain(found), Catch::StartsWith("0 candidates"));
}

TEST_CASE("the same scene gives the same candidates bit for bit", "[candidates]") {
  const auto seen = tests::see(table(), true);
  const auto a = planner::generate_candidates(seen.scene, HandModel{}, CandidateConfig{}, &seen.cloud);
  const auto b = planner::generate_candidates(seen.scene, HandModel{}, CandidateConfig{}, &seen.cloud);
  REQUIRE(a.size() == b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    CHECK(a[i].position == b[i].position);
    CHECK(a[i].reason == b[i].reason);
    CHECK(a[i].stability == b[i].stability);
  }
}

TEST_CASE("when nothing is free the summary counts the reasons and names the nearest miss", "[candidates]") {
  const auto refused = [](int id, const char* reason, double miss_m) {
    GraspCandidate c;
    c.id = id;
    c.verdict = Verdict::Collision;
    c.reason = reason;
    c.miss_m = miss_m;
    return c;
  };
  const std::vector<GraspCandidate> list{refused(0, "finger 2 meets the object 14 mm inside", 0.014),
                                         refused(1, "finger 2 meets the object 3 mm inside", 0.003),
                                         refused(2, "palm meets the ground 8 mm deep", 0.008)};
  CHECK(planner::explain(list) ==
        "0 of 3 candidates are free: 2 would meet the object, 1 would meet the ground; nearest miss: "
        "candidate 1, "
        "finger 2 meets the object 3 mm inside");
}
