#include "perception/bodies/body_tracker.hpp"

#include <catch2/catch.hpp>
#include <chrono>
#include <cmath>

#include "perception/bodies/body_distance.hpp"

using namespace colift;
using namespace colift::perception;
using namespace std::chrono_literals;
using hal::Vec3;

namespace {

Body at(const Vec3& center, double area_m2 = 0.3) {
  Body b;
  b.center = center;
  b.area_m2 = area_m2;
  return b;
}

}  // namespace

TEST_CASE("a walker keeps his name, and his velocity is measured within a third of a second") {
  BodyTracker tracker;
  int id = 0;
  BodyTrack last;
  for (int i = 0; i < 10; ++i) {
    const double t = i / 30.0;
    const Body bodies[] = {at({2.0 - 1.6 * t, 0.01 * (i % 2), 1.0}), at({0.0, 2.0, 1.0})};
    const auto tracks = tracker.update(i * 33'333'333ns, bodies);
    REQUIRE(tracks.size() == 2);
    if (i == 0) id = tracks[0].id;
    CHECK(tracks[0].id == id);
    CHECK(tracks[1].id == id + 1);
    last = tracks[0];
    CHECK(tracks[1].velocity_m_s.norm() < 1e-9);
  }
  CHECK(last.velocity_m_s.x() == Approx(-1.6).margin(0.1));
  CHECK(last.still_s == 0.0);
}

TEST_CASE("who comes back after the gap is somebody new") {
  BodyTracker tracker;
  const Body body[] = {at({1, 0, 1})};
  const int id = tracker.update(0ns, body)[0].id;
  CHECK(tracker.update(100ms, {}).empty());
  CHECK(tracker.update(300ms, body)[0].id == id);
  CHECK(tracker.update(900ms, body)[0].id != id);
}

TEST_CASE("who stands is at rest after the time that he stands") {
  BodyTracker tracker;
  const Body body[] = {at({1, 0, 1})};
  double still = 0;
  for (int i = 0; i <= 30; ++i) still = tracker.update(i * 33ms, body)[0].still_s;
  CHECK(still == Approx(0.99).margin(0.05));
}

TEST_CASE("the distance is that of the nearest pair, behind the visible side too") {
  SphereSet spheres;
  for (int i = 0; i < 13; ++i) spheres.add({0.1 * i, 0, 0}, 0.05);
  // seen from -y: 0.3 m before the spheres, with 0.25 m hidden behind it
  const BodyPoint open[] = {{{0.42F, -0.3F, 0.0F}, {0, 1, 0}, 0.0F}, {{2.42F, -0.3F, 0.0F}, {0, 1, 0}, 0.0F}};
  Approach near;
  REQUIRE(nearest_approach(open, spheres, 1.0, near));
  CHECK(near.distance_m == Approx(std::hypot(0.02, 0.3) - 0.05).margin(1e-5));
  CHECK(near.sphere == 4);
  const BodyPoint thick[] = {{{0.42F, -0.3F, 0.0F}, {0, 1, 0}, 0.25F}};
  REQUIRE(nearest_approach(thick, spheres, 1.0, near));
  CHECK(near.distance_m == Approx(std::hypot(0.02, 0.05) - 0.05).margin(1e-5));
  CHECK_FALSE(nearest_approach(open, spheres, 0.2, near));
  CHECK_FALSE(nearest_approach({}, spheres, 1.0, near));
}

TEST_CASE("a point inside a sphere has a negative distance") {
  SphereSet spheres;
  spheres.add({0, 0, 0}, 0.2);
  const BodyPoint inside[] = {{{0.05F, 0, 0}, {1, 0, 0}, 0.0F}};
  Approach near;
  REQUIRE(nearest_approach(inside, spheres, 1.0, near));
  CHECK(near.distance_m == Approx(-0.15).margin(1e-5));
}

TEST_CASE("how high somebody was is remembered when he crouches, and unknown above the image's border") {
  BodyTracker tracker;
  Body body = at({1, 0, 1});
  body.top_seen = true;
  body.box = hal::Aabb(Vec3(0.8, -0.2, 0.0), Vec3(1.2, 0.2, 1.7));
  CHECK(tracker.update(0ns, {&body, 1})[0].top_m == Approx(1.7));
  body.box.max().z() = 0.9;
  body.center.z() = 0.8;
  CHECK(tracker.update(33ms, {&body, 1})[0].top_m == Approx(1.7));
  body.top_seen = false;
  CHECK(std::isinf(tracker.update(66ms, {&body, 1})[0].top_m));
}
