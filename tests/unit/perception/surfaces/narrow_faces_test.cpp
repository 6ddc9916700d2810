#include <catch2/catch.hpp>

#include "views.hpp"

using namespace colift;
using namespace colift::perception;
using sim_hal::box;
using sim_hal::Label;

TEST_CASE("a crate's rim is found where no wall is seen beside it", "[surfaces]") {
  // from nearly beside it the end wall at -x shows its rim and nothing else
  constexpr double kWall = 0.015;
  const auto wall = [](const Vec3& at, const Vec3& size) { return box(at, size, 0, Label::Target); };
  int found = 0;
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const SurfaceView view(scene_of({wall({0, 0, kWall / 2}, {0.64, 0.34, kWall}),
                                     wall({-0.32 + kWall / 2, 0, 0.13}, {kWall, 0.34, 0.23}),
                                     wall({0.32 - kWall / 2, 0, 0.13}, {kWall, 0.34, 0.23}),
                                     wall({0, -0.17 + kWall / 2, 0.13}, {0.64 - 2 * kWall, kWall, 0.23}),
                                     wall({0, 0.17 - kWall / 2, 0.13}, {0.64 - 2 * kWall, kWall, 0.23})},
                                    {-0.3, -1.3, 1.1}, {0, 0, 0.1}),
                           seed);
    for (const Rectangle& r : rectangles_of(view.surfaces()))
      found += r.normal.z() > 0.99 && std::abs(r.center.x() + 0.32 - kWall / 2) < 0.01 &&
               std::abs(r.center.y()) < 0.04 && std::abs(r.center.z() - 0.245) < 0.01 && r.size.x() > 0.2 &&
               std::abs(r.u.y()) > 0.99 && r.size.y() < 0.03;
  }
  CHECK(found >= 8);
}

TEST_CASE("a handle of which a few pixels show beside its case is a face", "[surfaces]") {
  const auto part = [](const Vec3& at, const Vec3& size) { return box(at, size, 0, Label::Target); };
  int found = 0, beside = 0;
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const SurfaceView view(
        scene_of({part({0, 0, 0.245}, {0.76, 0.28, 0.49}), part({-0.423, 0, 0.337}, {0.018, 0.022, 0.166}),
                  part({-0.4, 0, 0.264}, {0.045, 0.022, 0.02}), part({-0.4, 0, 0.41}, {0.045, 0.022, 0.02})},
                 {-0.05, -1.5, 1.43}, {0, -0.08, 0.33}),
        seed);
    for (const Rectangle& r : rectangles_of(view.surfaces())) {
      const bool is_handle = std::abs(r.center.x() + 0.423) < 0.015 && std::abs(r.center.z() - 0.337) < 0.03;
      found += is_handle && std::abs(r.u.z()) > 0.98 && r.size.x() > 0.1 && r.size.y() < 0.03;
      beside += !is_handle && r.size.y() < 0.05;
    }
  }
  CHECK(found >= 8);
  CHECK(beside == 0);
}
