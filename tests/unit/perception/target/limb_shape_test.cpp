// Round or flat: what tells a leg from the leg of a table.
#include <algorithm>

#include "perception/ground/image_border.hpp"
#include "perception/target/person/limb_shape.hpp"
#include "synthetic.hpp"

namespace colift::perception {
namespace {

using namespace sim_hal;

const Pose kCamera = look_at(Vec3(-0.6, 0, 0.9), Vec3(1.2, 0, 0.3));
const Ground kGround{{Vec3::UnitZ(), 0.0}, 1000, 0.002};

// the largest region that stands on the floor
struct Seen {
  OrganisedCloud cloud;
  Components components;
  Fragment object;

  explicit Seen(const std::vector<Shape>& shapes, std::uint64_t seed = 3) {
    World world;
    world.shapes.push_back(half_space(Vec3::Zero(), Vec3::UnitZ(), Label::Ground));
    world.shapes.insert(world.shapes.end(), shapes.begin(), shapes.end());
    cloud = deproject(measure(cast_rays(world, {}, kCamera), {}, seed), kCamera);
    std::vector<std::uint8_t> mask(cloud.size(), 0);
    for (std::size_t i = 0; i < mask.size(); ++i) mask[i] = cloud.seen(i) && cloud.z[i] > 0.03f ? 1 : 0;
    components =
        connected_components(cloud.depth_m, mask, cloud.width(), cloud.height(), DepthJump{0.013f, 0.008f});
    const auto all = describe_fragments(cloud, components, kGround, find_image_border(cloud), {});
    REQUIRE_FALSE(all.empty());
    object = *std::max_element(all.begin(), all.end(),
                               [](const auto& a, const auto& b) { return a.pixels < b.pixels; });
  }

  [[nodiscard]] SurfaceCurvature curvature() const {
    return surface_curvature(cloud, components, object, NoiseModel());
  }
  [[nodiscard]] std::optional<LimbShape> limb() const {
    return find_limb(cloud, components, object, Silhouette(cloud, components, object, kGround), NoiseModel());
  }
};

Shape upright(double radius_m, double height_m) {
  return cylinder({1.2, 0, 0.5 * height_m}, Vec3::UnitZ(), radius_m, height_m, Label::Clutter);
}

}  // namespace

TEST_CASE("a slanted plane has no curvature, in any direction it faces", "[curvature]") {
  const double yaw = GENERATE(0.0, 0.4, 0.8);
  const Seen seen({box({1.3, 0, 0.3}, {0.5, 0.9, 0.6}, yaw, Label::Target)});
  const SurfaceCurvature s = seen.curvature();
  CHECK(s.pieces > 50);
  CHECK(std::abs(s.median_per_m) < 1.5);
  CHECK(s.convex < 0.4);
}

TEST_CASE("the curvature of a cylinder is the inverse of its radius", "[curvature]") {
  const double radius = GENERATE(0.06, 0.08, 0.12, 0.2);
  const Seen seen({upright(radius, 0.7)});
  const SurfaceCurvature s = seen.curvature();
  INFO(radius << " m: " << s.median_per_m << " +- " << s.sigma_per_m << " 1/m of " << s.pieces);
  REQUIRE(s.pieces > 10);
  CHECK(s.median_per_m > 0.85 / radius);
  CHECK(s.median_per_m < 1.2 / radius);
  CHECK(s.sigma_per_m < 0.2 / radius);
}

TEST_CASE("what is too thin to be measured says nothing", "[curvature]") {
  const Seen seen({box({1.2, 0, 0.3}, {0.03, 0.03, 0.6}, 0.3, Label::Target)});
  CHECK(seen.curvature().pieces == 0);
  CHECK_FALSE(seen.limb());
}

TEST_CASE("a leg, a trunk and a bent knee are parts of a person, a pipe, a drum and a carton are not",
          "[person]") {
  const auto capsule_of = [](const Vec3& from, const Vec3& to, double radius) {
    return capsule(from, to, radius, Label::Partner);
  };
  const auto seed = static_cast<std::uint64_t>(GENERATE(1, 2, 3));
  SECTION("a leg with its foot") {
    const Seen seen({capsule_of({1.2, 0, 0.06}, {1.2, 0.03, 0.7}, 0.055),
                     capsule_of({1.2, 0, 0.05}, {1.05, 0, 0.05}, 0.045)},
                    seed);
    REQUIRE(seen.limb());
    CHECK(seen.limb()->radius_m > 0.02);
    CHECK(seen.limb()->radius_m < 0.08);
  }
  SECTION("a knee") {
    CHECK(Seen({capsule_of({1.2, 0, 0.06}, {1.1, 0, 0.5}, 0.05),
                capsule_of({1.1, 0, 0.5}, {1.3, 0.35, 0.55}, 0.075)},
               seed)
              .limb());
  }
  SECTION("a trunk") {
    CHECK(Seen({capsule_of({1.2, 0, 0.15}, {1.2, 0, 0.6}, 0.125)}, seed).limb());
  }
  SECTION("a pipe on the floor") {
    CHECK_FALSE(
        Seen({cylinder({1.15, 0, 0.06}, Vec3(0.3, 1.0, 0).normalized(), 0.05, 1.0, Label::Target)}, seed)
            .limb());
  }
  SECTION("a drum") {
    CHECK_FALSE(Seen({upright(0.25, 0.6)}, seed).limb());
  }
  SECTION("a can") {
    CHECK_FALSE(Seen({upright(0.035, 0.15)}, seed).limb());
  }
  SECTION("a frame of tubes") {
    const Vec3 rear{1.2, -0.4, 0.3}, front{1.2, 0.4, 0.3}, crank{1.2, -0.05, 0.25}, seat{1.2, -0.2, 0.7},
        head{1.2, 0.3, 0.7};
    std::vector<Shape> tubes;
    for (const auto& [from, to] : {std::pair{seat, head},
                                   {crank, head},
                                   {crank, seat},
                                   {rear, seat},
                                   {rear, crank},
                                   {front, head},
                                   {rear, Vec3(1.2, -0.4, 0.0)}})
      tubes.push_back(capsule_of(from, to, 0.017));
    CHECK_FALSE(Seen(tubes, seed).limb());
  }
  SECTION("a carton") {
    CHECK_FALSE(Seen({box({1.2, 0, 0.2}, {0.3, 0.4, 0.4}, 0.5, Label::Target)}, seed).limb());
  }
}

}  // namespace colift::perception
