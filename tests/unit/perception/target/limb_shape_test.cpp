// Round or flat: what tells a leg from the leg of a table.
#include "seen_object.hpp"

namespace colift::perception {
namespace {

using namespace sim_hal;

Shape upright(double radius_m, double height_m) {
  return cylinder({1.2, 0, 0.5 * height_m}, Vec3::UnitZ(), radius_m, height_m, Label::Clutter);
}

}  // namespace

TEST_CASE("a slanted plane has no curvature, in any direction it faces", "[curvature]") {
  const double yaw = GENERATE(0.0, 0.4, 0.8);
  const SeenObject seen({box({1.3, 0, 0.3}, {0.5, 0.9, 0.6}, yaw, Label::Target)});
  const SurfaceCurvature s = seen.curvature();
  CHECK(s.pieces > 50);
  CHECK(std::abs(s.median_per_m) < 1.5);
  CHECK(s.convex < 0.4);
}

TEST_CASE("the curvature of a cylinder is the inverse of its radius", "[curvature]") {
  const double radius = GENERATE(0.06, 0.08, 0.12, 0.2);
  const SeenObject seen({upright(radius, 0.7)});
  const SurfaceCurvature s = seen.curvature();
  INFO(radius << " m: " << s.median_per_m << " +- " << s.sigma_per_m << " 1/m of " << s.pieces);
  REQUIRE(s.pieces > 10);
  CHECK(s.median_per_m > 0.85 / radius);
  CHECK(s.median_per_m < 1.2 / radius);
  CHECK(s.sigma_per_m < 0.2 / radius);
}

TEST_CASE("what is too thin to be measured says nothing", "[curvature]") {
  const SeenObject seen({box({1.2, 0, 0.3}, {0.03, 0.03, 0.6}, 0.3, Label::Target)});
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
    const SeenObject seen({capsule_of({1.2, 0, 0.06}, {1.2, 0.03, 0.7}, 0.055),
                           capsule_of({1.2, 0, 0.05}, {1.05, 0, 0.05}, 0.045)},
                          seed);
    REQUIRE(seen.limb());
    CHECK(seen.limb()->radius_m > 0.02);
    CHECK(seen.limb()->radius_m < 0.08);
  }
  SECTION("a knee") {
    CHECK(SeenObject({capsule_of({1.2, 0, 0.06}, {1.1, 0, 0.5}, 0.05),
                      capsule_of({1.1, 0, 0.5}, {1.3, 0.35, 0.55}, 0.075)},
                     seed)
              .limb());
  }
  SECTION("a trunk") {
    CHECK(SeenObject({capsule_of({1.2, 0, 0.15}, {1.2, 0, 0.6}, 0.125)}, seed).limb());
  }
  SECTION("a pipe on the floor") {
    CHECK_FALSE(
        SeenObject({cylinder({1.15, 0, 0.06}, Vec3(0.3, 1.0, 0).normalized(), 0.05, 1.0, Label::Target)},
                   seed)
            .limb());
  }
  SECTION("a drum") {
    CHECK_FALSE(SeenObject({upright(0.25, 0.6)}, seed).limb());
  }
  SECTION("a can") {
    CHECK_FALSE(SeenObject({upright(0.035, 0.15)}, seed).limb());
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
    CHECK_FALSE(SeenObject(tubes, seed).limb());
  }
  SECTION("a carton") {
    CHECK_FALSE(SeenObject({box({1.2, 0, 0.2}, {0.3, 0.4, 0.4}, 0.5, Label::Target)}, seed).limb());
  }
}

}  // namespace colift::perception
