#include <fmt/format.h>

#include <algorithm>

#include "synthetic.hpp"

namespace colift::perception {
namespace {

using sim_hal::ObjectKind;

TargetResult target_of(const OrganisedCloud& cloud, const std::optional<Vec3>& at = std::nullopt) {
  const NoiseModel noise;
  const auto blocks = fit_block_planes(cloud, noise);
  const GroundResult g = find_ground(cloud, blocks, Vec3(Vec3::UnitZ()), noise, {});
  REQUIRE(g.ground);
  return find_target(cloud, blocks, *g.ground, noise, {}, at);
}

/// Pixels with this label that were seen, and those of them that are the target's.
struct Found {
  int seen = 0, of_target = 0;
};

Found found_of(sim_hal::Label label, const sim_hal::Rendering& truth, const OrganisedCloud& cloud,
               const Target& target) {
  std::vector<bool> mine(cloud.size(), false);
  for (const std::uint32_t p : target.pixels) mine[p] = true;
  Found found;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if (!cloud.seen(i) || truth.label[i] != label) continue;
    ++found.seen;
    found.of_target += mine[i];
  }
  return found;
}

}  // namespace

TEST_CASE("the target's mask covers the truth on noisy frames", "[target]") {
  const ObjectKind kind =
      GENERATE(ObjectKind::Table, ObjectKind::Box, ObjectKind::OpenBox, ObjectKind::Pipe, ObjectKind::Chair);
  std::vector<double> ious;
  std::string name;
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    const SceneView view(kind, seed);
    name = view.scene.name;
    if (name.find("blocks") != std::string::npos)
      continue;  // what lies on its neighbours is one object with them
    const TargetResult r = target_of(view.cloud);
    INFO(name << " seed " << seed << ": " << r.reason);
    REQUIRE(r.target);
    ious.push_back(overlap(view, r.target->pixels));
    // the camera's ragged edges alone move up to a pixel on either side of a thin pipe or slat
    const bool thin = kind == ObjectKind::Pipe || kind == ObjectKind::Chair;
    CHECK(ious.back() >= (thin ? 0.93 : 0.95));
  }
  std::sort(ious.begin(), ious.end());
  fmt::print("target {}: IoU least {:.3f} median {:.3f}\n", name, ious.front(), ious[ious.size() / 2]);
}

TEST_CASE("a point picks its object instead of the largest", "[target]") {
  using namespace sim_hal;
  World world;
  world.shapes.push_back(half_space(Vec3::Zero(), Vec3::UnitZ(), Label::Ground));
  world.shapes.push_back(box(Vec3(0.2, 0.5, 0.25), Vec3(0.5, 0.5, 0.5), 0.3, Label::Clutter));
  world.shapes.push_back(box(Vec3(0.0, -0.4, 0.1), Vec3(0.2, 0.2, 0.2), 0.0, Label::Target));
  const Pose X_WC = look_at(Vec3(-1.4, 0, 1.2), Vec3(0, 0, 0.2));
  const OrganisedCloud cloud = deproject(measure(cast_rays(world, {}, X_WC), {}, 5), X_WC);

  const TargetResult largest = target_of(cloud);
  REQUIRE(largest.target);
  CHECK(largest.target->obb.center.y() > 0.2);
  const TargetResult picked = target_of(cloud, Vec3(0.0, -0.4, 0.1));
  REQUIRE(picked.target);
  CHECK(std::abs(picked.target->obb.center.y() + 0.4) < 0.05);
  CHECK(picked.reason.find("given point") != std::string::npos);
}

TEST_CASE("a handle that goes on behind the end of its suitcase is part of it, a box behind it is not",
          "[target]") {
  using namespace sim_hal;
  World world;
  world.shapes.push_back(half_space(Vec3::Zero(), Vec3::UnitZ(), Label::Ground));
  world.shapes.push_back(box({0, 0, 0.24}, {0.70, 0.25, 0.48}, 0.0, Label::Target));
  world.shapes.push_back(box({0.395, 0, 0.30}, {0.018, 0.022, 0.17}, 0.0, Label::Partner));
  for (const double z : {0.22, 0.38})
    world.shapes.push_back(box({0.372, 0, z}, {0.045, 0.02, 0.02}, 0.0, Label::Partner));
  world.shapes.push_back(box({-0.45, 0.3, 0.15}, {0.2, 0.2, 0.3}, 0.0, Label::Clutter));
  const Pose X_WC = look_at(Vec3(-0.1, -1.7, 1.2), Vec3(0, 0, 0.25));
  const Rendering truth = cast_rays(world, {}, X_WC);
  const OrganisedCloud cloud = deproject(measure(truth, {}, 5), X_WC);
  const TargetResult found = target_of(cloud);
  REQUIRE(found.target);
  const Found handle = found_of(Label::Partner, truth, cloud, *found.target);
  const Found clutter = found_of(Label::Clutter, truth, cloud, *found.target);
  INFO(handle.of_target << " of " << handle.seen << " pixels of the handle, " << clutter.of_target
                        << " of the box");
  CHECK(handle.seen > 150);
  CHECK(handle.of_target > handle.seen / 2);
  CHECK(clutter.of_target < 100);  // a few at the rim, of thousands
}

TEST_CASE("fork and handlebar lean on the frame that they belong to; a bottle beside it stands alone",
          "[target]") {
  using namespace sim_hal;
  World world;
  world.shapes.push_back(half_space(Vec3::Zero(), Vec3::UnitZ(), Label::Ground));
  const double turn = -0.227;
  const auto at = [&](double x, double y, double z) {
    return Vec3(Eigen::AngleAxisd(turn, Vec3::UnitZ()) * Vec3(x, y, z));
  };
  const auto tube = [&](const Vec3& a, const Vec3& b, Label label) {
    world.shapes.push_back(capsule(a, b, 0.014, label));
  };
  const Vec3 seat = at(-0.20, 0, 0.73), crank = at(-0.08, 0, 0.26), rear = at(-0.48, 0, 0.31);
  const Vec3 front = at(0.48, 0, 0.31), head = at(0.33, 0, 0.71);
  world.shapes.push_back(box(at(-0.23, 0, 0.826), {0.24, 0.12, 0.05}, turn, Label::Target));
  tube(seat, at(0.33, 0, 0.67), Label::Target);
  tube(crank, at(0.33, 0, 0.60), Label::Target);
  tube(crank, at(-0.22, 0, 0.81), Label::Target);
  tube(rear, crank, Label::Target);
  tube(rear, seat, Label::Target);
  tube(at(-0.48, 0, 0.02), rear, Label::Target);
  tube(front, head, Label::Partner);
  tube(at(0.48, 0, 0.02), front, Label::Partner);
  for (const double x : {-0.48, 0.48})
    world.shapes.push_back(box(at(x, 0, 0.01), {0.06, 0.34, 0.02}, turn, Label::Ground));
  tube(at(0.33, -0.26, 0.726), at(0.33, 0.26, 0.726), Label::Partner);
  world.shapes.push_back(cylinder(at(-0.59, 0, 0.15), Vec3::UnitZ(), 0.04, 0.30, Label::Clutter));
  const Pose X_WC = look_at(Vec3(0.16, -1.59, 1.76), Vec3(-0.05, -0.02, 0.52));
  const Rendering truth = cast_rays(world, {}, X_WC);
  const std::uint64_t seed = GENERATE(range(1, 13));
  const OrganisedCloud cloud = deproject(measure(truth, {}, seed), X_WC);
  const TargetResult found = target_of(cloud);
  REQUIRE(found.target);
  const Found fork = found_of(Label::Partner, truth, cloud, *found.target);
  const Found bottle = found_of(Label::Clutter, truth, cloud, *found.target);
  INFO(fork.of_target << " of " << fork.seen << " pixels of the fork, " << bottle.of_target << " of "
                      << bottle.seen << " of the bottle");
  CHECK(fork.seen > 1500);
  CHECK(fork.of_target > 3 * fork.seen / 4);
  CHECK(bottle.seen > 1000);
  CHECK(bottle.of_target < 100);
}

TEST_CASE(
    "a bench goes on under its seat as far as it needs to stand; a carton under a table does not belong to "
    "it",
    "[target]") {
  using namespace sim_hal;
  const std::uint64_t seed = GENERATE(range(1, 7));
  World world;
  world.shapes.push_back(half_space(Vec3::Zero(), Vec3::UnitZ(), Label::Ground));
  Pose X_WC;
  SECTION(
      "bench: of one end the leg's narrow side is seen, the other end and the bar between them below it") {
    const double turn = -0.349;
    const auto body = [&](const Vec3& at, const Vec3& size, Label label) {
      world.shapes.push_back(box(Eigen::AngleAxisd(turn, Vec3::UnitZ()) * at, size, turn, label));
    };
    body({0, 0, 0.40}, {1.18, 0.32, 0.027}, Label::Target);
    body({0.405, 0, 0.194}, {0.03, 0.27, 0.387}, Label::Target);
    body({-0.405, 0, 0.194}, {0.03, 0.27, 0.387}, Label::Partner);
    body({0, 0, 0.166}, {0.78, 0.025, 0.06}, Label::Partner);
    X_WC = look_at(Vec3(0.09, -1.22, 1.15), Vec3(0.05, 0.01, 0.25));
    const Rendering truth = cast_rays(world, {}, X_WC);
    const OrganisedCloud cloud = deproject(measure(truth, {}, seed), X_WC);
    const TargetResult found = target_of(cloud);
    REQUIRE(found.target);
    const Found below = found_of(Label::Partner, truth, cloud, *found.target);
    INFO(below.of_target << " of " << below.seen << " pixels");
    CHECK(below.seen > 2000);
    CHECK(below.of_target > 9 * below.seen / 10);
  }
  SECTION("table: two legs are seen, and what stands behind them") {
    world.shapes.push_back(box({0, 0, 0.60}, {1.1, 0.6, 0.03}, 0.2, Label::Target));
    for (const double x : {-0.5, 0.5})
      for (const double y : {-0.25, 0.25})
        world.shapes.push_back(box(Eigen::AngleAxisd(0.2, Vec3::UnitZ()) * Vec3(x, y, 0.29),
                                   {0.05, 0.05, 0.58}, 0.2, Label::Target));
    world.shapes.push_back(box({0.0, 0.1, 0.15}, {0.35, 0.25, 0.30}, 0.5, Label::Clutter));
    X_WC = look_at(Vec3(0.1, -1.6, 1.1), Vec3(0, 0, 0.35));
    const Rendering truth = cast_rays(world, {}, X_WC);
    const OrganisedCloud cloud = deproject(measure(truth, {}, seed), X_WC);
    const TargetResult found = target_of(cloud);
    REQUIRE(found.target);
    const Found carton = found_of(Label::Clutter, truth, cloud, *found.target);
    INFO(carton.of_target << " of " << carton.seen << " pixels");
    CHECK(carton.seen > 1000);
    CHECK(carton.of_target < 100);
  }
}

TEST_CASE("a table top in the air has the foot under it, which it hides for the most part", "[target]") {
  using namespace sim_hal;
  const std::uint64_t seed = GENERATE(range(1, 7));
  World world;
  world.shapes.push_back(half_space(Vec3::Zero(), Vec3::UnitZ(), Label::Ground));
  const auto upright = [&](double height, double radius, double length, Label label) {
    world.shapes.push_back(cylinder({1.05, 0, height}, Vec3::UnitZ(), radius, length, label));
  };
  upright(0.60, 0.35, 0.025, Label::Target);
  upright(0.31, 0.03, 0.56, Label::Partner);
  upright(0.015, 0.22, 0.03, Label::Partner);
  const Pose X_WC = look_at(Vec3(2.1, -1.4, 1.5), Vec3(1.15, 0, 0.3));
  const Rendering truth = cast_rays(world, {}, X_WC);
  const OrganisedCloud cloud = deproject(measure(truth, {}, seed), X_WC);
  const TargetResult found = target_of(cloud);
  REQUIRE(found.target);
  const Found top = found_of(Label::Target, truth, cloud, *found.target);
  const Found foot = found_of(Label::Partner, truth, cloud, *found.target);
  INFO(top.of_target << " of " << top.seen << " pixels of the top, " << foot.of_target << " of "
                     << foot.seen);
  CHECK(top.of_target > 9 * top.seen / 10);
  CHECK(foot.seen > 3000);
  CHECK(foot.of_target > 8 * foot.seen / 10);
}

TEST_CASE("an object that the image cuts at the side is not free-standing", "[target]") {
  using namespace sim_hal;
  World world;
  world.shapes.push_back(half_space(Vec3::Zero(), Vec3::UnitZ(), Label::Ground));
  world.shapes.push_back(
      box(Vec3(0.0, 1.15, 0.3), Vec3(0.6, 0.9, 0.6), 0.0, Label::Clutter));  // leaves the view
  world.shapes.push_back(box(Vec3(0.0, -0.2, 0.15), Vec3(0.3, 0.3, 0.3), 0.0, Label::Target));
  const Pose X_WC = look_at(Vec3(-1.4, 0, 1.2), Vec3(0, 0, 0.2));
  const TargetResult r = target_of(deproject(measure(cast_rays(world, {}, X_WC), {}, 5), X_WC));
  REQUIRE(r.target);
  CHECK(r.target->obb.center.y() < 0.1);
  CHECK(std::any_of(r.rejected.begin(), r.rejected.end(),
                    [](const auto& o) { return o.kind == RejectedObject::Kind::Cut; }));
}

TEST_CASE("a bare floor has no target, and says so", "[target]") {
  using namespace sim_hal;
  World world;
  world.shapes.push_back(half_space(Vec3::Zero(), Vec3::UnitZ(), Label::Ground));
  const Pose X_WC = look_at(Vec3(-1.4, 0, 1.2), Vec3(0, 0, 0.2));
  const TargetResult r = target_of(deproject(measure(cast_rays(world, {}, X_WC), {}, 5), X_WC));
  CHECK_FALSE(r.target);
  CHECK(r.reason.find("no target") == 0);
}

TEST_CASE("a person is not a target", "[target]") {
  using namespace sim_hal;
  int seen = 0, taken = 0;
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    const SyntheticScene scene = make_scene(ObjectKind::Box, seed);
    World world = with_passer_by(scene, seed, false);
    std::erase_if(world.shapes,
                  [](const Shape& s) { return s.label != Label::Ground && s.label != Label::Partner; });
    const Rendering truth = cast_rays(world, scene.intrinsics, scene.X_WC);
    for (std::uint64_t draw = 0; draw < 3; ++draw) {
      const TargetResult r = target_of(deproject(measure(truth, {}, seed + 100 * draw), scene.X_WC));
      UNSCOPED_INFO(seed << ": " << r.reason);
      taken += r.target ? 1 : 0;
      seen += std::any_of(r.rejected.begin(), r.rejected.end(),
                          [](const auto& o) { return o.kind == RejectedObject::Kind::Person; });
    }
  }
  CHECK(taken <= 2);  // of 18: of whom the view cuts all but the legs is hard to tell from a stool
  CHECK(seen >= 9);
}

TEST_CASE("the same frame gives the same target, bit for bit", "[target]") {
  const SceneView view(ObjectKind::Table, 2);
  const TargetResult a = target_of(view.cloud), b = target_of(view.cloud);
  REQUIRE(a.target);
  CHECK(a.target->pixels == b.target->pixels);
  CHECK(a.target->obb.center == b.target->obb.center);
  CHECK(a.reason == b.reason);
}

}  // namespace colift::perception
