#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "planner/motion/joint_random.hpp"
#include "planner/motion/rrt_connect.hpp"
#include "planner/motion/shortcut.hpp"

namespace {

using namespace colift::planner;
using colift::hal::JointVector;

/// A wall across joint space at q0 in [-0.1, 0.1] with one square hole in q1 and q2.
struct WallWithHole {
  double hole_at = 0.8, half_hole = 0.15;

  [[nodiscard]] bool free(const JointVector& q) const {
    if (std::abs(q[0]) > 0.1) return true;
    return std::abs(q[1] - hole_at) < half_hole && std::abs(q[2] + hole_at) < half_hole;
  }
  [[nodiscard]] bool free(const JointVector& a, const JointVector& b, double step) const {
    const int steps = std::max(1, static_cast<int>(std::ceil(joint_distance(a, b) / step)));
    for (int i = 0; i <= steps; ++i) {
      if (!free(JointVector(a + (static_cast<double>(i) / steps) * (b - a)))) return false;
    }
    return true;
  }
  [[nodiscard]] FreeSpace space() const {
    return {[this](const JointVector& q) { return free(q); },
            [this](const JointVector& a, const JointVector& b) { return free(a, b, 0.04); }};
  }
};

const JointBox kBox{JointVector::Constant(-1.5), JointVector::Constant(1.5)};

JointVector at(double first) {
  JointVector q = JointVector::Zero();
  q[0] = first;
  return q;
}

bool finely_free(const WallWithHole& wall, const JointPath& path) {
  for (std::size_t i = 1; i < path.size(); ++i) {
    if (!wall.free(path[i - 1], path[i], 0.04)) return false;
  }
  return true;
}

}  // namespace

TEST_CASE("a way is found through a hole in joint space") {
  const WallWithHole wall;
  const FreeSpace space = wall.space();
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    std::size_t used = 0;
    const auto found = rrt_connect(space, kBox, at(-1.0), std::vector{at(1.0)}, {50000}, seed, used);
    REQUIRE(found);
    CHECK(found->path.front() == at(-1.0));
    CHECK(found->path.back() == at(1.0));
    CHECK(finely_free(wall, found->path));
    CHECK(used > 0);
    for (const JointVector& q : found->path) CHECK(kBox.contains(q));
  }
}

TEST_CASE("same seed, same way; another seed, another way") {
  const WallWithHole wall;
  const FreeSpace space = wall.space();
  const auto run = [&](std::uint64_t seed) {
    std::size_t used = 0;
    const auto found = rrt_connect(space, kBox, at(-1.0), std::vector{at(1.0)}, {50000}, seed, used);
    REQUIRE(found);
    return shortcut(found->path, space, seed);
  };
  const JointPath once = run(7);
  run(8);  // what others drew in between must not matter
  CHECK(run(7) == once);
  CHECK(run(8) != once);
}

TEST_CASE("the goal that a way ends in is named") {
  const WallWithHole wall;
  const FreeSpace space = wall.space();
  // the first goal cannot be entered: no hole leads to it
  FreeSpace walled = space;
  const auto locked = [](const JointVector& q) { return q[0] > 0.9 && q[3] > 0.5 && q[3] < 0.7; };
  walled.edge = [&](const JointVector& a, const JointVector& b) {
    return space.edge(a, b) && !locked(b) && !locked(a);
  };
  JointVector first = at(1.0);
  first[3] = 0.6;
  std::size_t used = 0;
  const auto found = rrt_connect(walled, kBox, at(-1.0), std::vector{first, at(1.2)}, {50000}, 3, used);
  REQUIRE(found);
  CHECK(found->goal == 1);
  CHECK(found->path.back() == at(1.2));
}

TEST_CASE("a search without a way ends with its budget") {
  WallWithHole wall;
  wall.half_hole = 0.0;
  std::size_t used = 0;
  const auto found = rrt_connect(wall.space(), kBox, at(-1.0), std::vector{at(1.0)}, {2000}, 1, used);
  CHECK_FALSE(found);
  CHECK(used >= 2000);
  CHECK(used < 2010);
}

TEST_CASE("shortcuts stay free, keep both ends and never lengthen a way") {
  const WallWithHole wall;
  const FreeSpace space = wall.space();
  double before = 0.0, after = 0.0;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    std::size_t used = 0;
    const auto found = rrt_connect(space, kBox, at(-1.0), std::vector{at(1.0)}, {50000}, seed, used);
    REQUIRE(found);
    const JointPath shorter = shortcut(found->path, space, seed);
    CHECK(shorter.front() == found->path.front());
    CHECK(shorter.back() == found->path.back());
    // a part of an edge is looked at in other places than the edge was: as much as a step lies between
    CHECK(finely_free({wall.hole_at, wall.half_hole + 0.05}, shorter));
    CHECK(length_of(shorter) <= length_of(found->path) + 1e-12);
    before += length_of(found->path);
    after += length_of(shorter);
  }
  // through the near corner of the hole: (-1, 0, 0) to (0, 0.65, -0.65) to (1, 0, 0)
  const double shortest = 2.0 * std::sqrt(1.0 + 2.0 * 0.65 * 0.65);
  CHECK(after / 20.0 < 1.35 * shortest);
  CHECK(after < 0.8 * before);
}

TEST_CASE("a detour around nothing becomes a straight line") {
  const FreeSpace open{[](const JointVector&) { return true; },
                       [](const JointVector&, const JointVector&) { return true; }};
  JointRandom random(5);
  JointPath path;
  for (int i = 0; i < 12; ++i) path.push_back(random.in(kBox));
  const JointPath straight = shortcut(path, open, 1);
  REQUIRE(straight.size() == 2);
  CHECK(straight.front() == path.front());
  CHECK(straight.back() == path.back());
}
