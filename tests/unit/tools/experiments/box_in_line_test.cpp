#include <catch2/catch.hpp>
#include <cmath>

#include "tools/experiments/trials/box_in_line.hpp"

using namespace colift;
using experiments::box_in_line;
using experiments::share_forbidden;

TEST_CASE("a box laid out for a share permits that share", "[layouts]") {
  for (const std::uint64_t seed : {2, 3}) {
    for (int index = 1; index < 40; ++index) {
      for (const double share : {0.30, 0.50, 0.67}) {
        const auto box = box_in_line(index, seed, share);
        INFO("seed " << seed << ", box " << index << ", share " << share << ", "
                     << share_forbidden(box, share).value_or("possible"));
        CHECK_FALSE(share_forbidden(box, share));
        CHECK(box.partner.grasp.y() == 0.0);
        // the lever rule puts the robot's place on the box
        const double place = box.partner.grasp.x() * (1.0 - share) / share;
        CHECK(place < 0.5 * box.object.size[0]);
        CHECK(box.partner.grasp.x() <= 0.5 * box.object.size[0] + 1e-9);
      }
    }
  }
}

TEST_CASE("a share that statics, reach or the partner's hands forbid is not asked for", "[layouts]") {
  // the partner at the far end: nobody can bear less than half of it
  auto box = box_in_line(0, 1, 0.5);
  REQUIRE_FALSE(share_forbidden(box, 0.5));
  CHECK_THAT(share_forbidden(box, 0.3).value(), Catch::Contains("beyond where the box can be held"));
  CHECK_THAT(share_forbidden(box, 0.67).value(), Catch::Contains("beyond the arm's reach"));
  // nearer to the robot its inner places come into reach
  box.object.xyz.x() -= 0.25;
  CHECK_FALSE(share_forbidden(box, 0.67));
  box.partner.grasp.x() = 0.12;
  CHECK_THAT(share_forbidden(box, 0.67).value(), Catch::Contains("mm apart"));
}

TEST_CASE("the same arguments lay out the same box", "[layouts]") {
  const auto a = box_in_line(7, 3, 0.3), b = box_in_line(7, 3, 0.3);
  CHECK(a.object.xyz == b.object.xyz);
  CHECK(a.object.size == b.object.size);
  CHECK(a.partner.grasp == b.partner.grasp);
  CHECK(a.camera.xyz == b.camera.xyz);
}
