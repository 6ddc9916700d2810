#include "perception/target/slivers.hpp"

#include <algorithm>

#include "perception/target/regions/enclosed_pixels.hpp"
#include "synthetic.hpp"

using namespace colift;
using namespace colift::perception;

namespace {

Target target_of(const SceneView& view, Ground& ground) {
  const NoiseModel noise;
  const auto blocks = fit_block_planes(view.cloud, noise);
  const GroundResult g = find_ground(view.cloud, blocks, Vec3(Vec3::UnitZ()), noise, {});
  REQUIRE(g.ground);
  ground = *g.ground;
  const TargetResult found = find_target(view.cloud, blocks, ground, noise, {});
  REQUIRE(found.target);
  return *found.target;
}

}  // namespace

TEST_CASE("a part of the target that was not taken for it is a sliver, and nothing of others is",
          "[slivers]") {
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    const SceneView view(sim_hal::ObjectKind::Chair, seed);
    Ground ground;
    Target target = target_of(view, ground);
    // a band of 6 cm around the middle of its highest part is given away
    const Vec3 at = target.aabb.center();
    std::vector<std::uint32_t> kept, given;
    for (const std::uint32_t i : target.pixels) {
      const Vec3 p = view.cloud.point(i);
      const bool away = std::abs(p.z() - at.z()) < 0.03 && given.size() < 60;
      (away ? given : kept).push_back(i);
    }
    REQUIRE(given.size() >= 20);
    target.pixels = kept;
    const auto slivers = find_slivers(view.cloud, target, ground, NoiseModel{});
    CHECK(std::is_sorted(slivers.begin(), slivers.end()));
    const auto found = std::count_if(given.begin(), given.end(), [&](std::uint32_t i) {
      return std::binary_search(slivers.begin(), slivers.end(), i);
    });
    INFO(view.scene.name << " seed " << seed << ": " << found << " of " << given.size());
    CHECK(10 * found >= 8 * static_cast<std::ptrdiff_t>(given.size()));
    for (const std::uint32_t i : slivers) {
      CHECK_FALSE(std::binary_search(kept.begin(), kept.end(), i));
      CHECK(view.cloud.point(i).z() > 0.01);
    }
  }
}

TEST_CASE("what reaches out of the target's box is something else", "[slivers]") {
  using namespace sim_hal;
  SyntheticScene scene;
  scene.world.shapes = {half_space(Vec3::Zero(), Vec3::UnitZ(), Label::Ground),
                        box({0, 0, 0.45}, {0.6, 0.6, 0.03}, 0, Label::Target),
                        box({0, 0, 0.60}, {0.03, 0.03, 0.04}, 0, Label::Clutter),
                        box({0.30, 0, 0.60}, {0.4, 0.02, 0.02}, 0, Label::Clutter)};
  scene.X_WC = look_at({-1.6, 0.3, 1.5}, {0, 0, 0.4});
  const Rendering truth = cast_rays(scene.world, scene.intrinsics, scene.X_WC);
  const OrganisedCloud cloud = deproject(measure_ideal(truth), scene.X_WC);
  Target target;
  for (std::uint32_t i = 0; i < cloud.size(); ++i)
    if (cloud.seen(i) && truth.label[i] == Label::Target) target.pixels.push_back(i);
  // as far up as a back rest would reach
  target.obb.center = {0, 0, 0.4};
  target.obb.size = {0.6, 0.6, 0.8};
  Ground ground;
  ground.plane = {Vec3::UnitZ(), 0.0};
  int inside = 0, outside = 0;
  for (const std::uint32_t i : find_slivers(cloud, target, ground, NoiseModel{}))
    (cloud.point(i).x() < 0.05 ? inside : outside) += 1;
  CHECK(inside > 20);   // the small block
  CHECK(outside == 0);  // the bar
}

TEST_CASE("a pixel between an edge and what lies behind it is not enclosed", "[target]") {
  hal::DepthFrame frame;
  frame.intrinsics = {40, 40, 40.0, 40.0, 20.0, 20.0};
  frame.depth_m.assign(1600, 1.5f);
  std::vector<std::uint32_t> ring;
  for (std::uint32_t v = 10; v < 30; ++v)
    for (std::uint32_t u = 10; u < 30; ++u) {
      const bool inside = u > 11 && u < 28 && v > 11 && v < 28;
      if (inside) continue;
      ring.push_back(v * 40 + u);
      frame.depth_m[v * 40 + u] = 1.2f;
    }
  const std::uint32_t stray = 20 * 40 + 12;
  frame.depth_m[stray] = 1.35f;
  Pose X_WC = Pose::Identity();
  X_WC.linear() << 1, 0, 0, 0, -1, 0, 0, 0, -1;
  X_WC.translation() = Vec3(0, 0, 1.5);
  const OrganisedCloud cloud = deproject(frame, X_WC);
  Ground ground;
  ground.plane = {Vec3::UnitZ(), 0.0};
  const auto inside =
      enclosed_pixels(cloud, ground, ring, std::vector<std::uint8_t>(1600, 0), DepthJump{0.03f, 0.0f}, 3);
  CHECK(inside.size() > 100);
  CHECK_FALSE(std::binary_search(inside.begin(), inside.end(), stray));
}
