// Persons in every stance: they touch the floor, are as high as their stance, and stand clear of what else is
// in a room.
#include "sim_hal/synthetic/stances.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <map>
#include <set>

#include "sim_hal/synthetic/rooms.hpp"

namespace colift::sim_hal {
namespace {

struct Heights {
  double low = 1e9, high = -1e9;
};

Heights heights(const std::vector<Shape>& parts) {
  Heights h;
  for (const Shape& s : parts)
    for (const double end : {-0.5, 0.5}) {
      const double z = (s.X_WS * Vec3(0, 0, end * s.size[1])).z();
      h.low = std::min(h.low, z - s.size[0]);
      h.high = std::max(h.high, z + s.size[0]);
    }
  return h;
}

}  // namespace

TEST_CASE("somebody in any stance touches the floor, and is as high as the stance says", "[stances]") {
  const std::map<Stance, std::pair<double, double>> kHigh{
      {Stance::Standing, {1.4, 2.3}},      {Stance::Stooping, {0.8, 1.9}},
      {Stance::SittingLow, {0.6, 1.5}},    {Stance::Crouching, {0.7, 1.6}},
      {Stance::Kneeling, {0.7, 1.9}},      {Stance::OnOneKnee, {0.8, 1.9}},
      {Stance::OnAllFours, {0.5, 1.2}},    {Stance::LyingOnBack, {0.2, 0.75}},
      {Stance::LyingFaceDown, {0.2, 0.7}}, {Stance::LyingOnSide, {0.3, 0.9}}};
  for (const Stance stance : kStances) {
    for (std::uint64_t seed = 1; seed <= 50; ++seed) {
      Draws draws(seed, 1);
      const std::vector<Shape> parts = person_in(stance, draws, {1.0, 2.0, 0.0}, 0.3);
      const Heights h = heights(parts);
      INFO(word(stance) << ", seed " << seed << ": " << h.low << " to " << h.high);
      CHECK(h.low == Approx(0.0).margin(1e-9));
      CHECK(h.high > kHigh.at(stance).first);
      CHECK(h.high < kHigh.at(stance).second);
      for (const Shape& s : parts) CHECK(s.label == Label::Partner);
    }
  }
}

TEST_CASE("the same draws make the same person", "[stances]") {
  Draws one(4, 1), two(4, 1);
  const auto a = person_in(Stance::LyingOnSide, one, Vec3::Zero(), 0.0),
             b = person_in(Stance::LyingOnSide, two, Vec3::Zero(), 0.0);
  REQUIRE(a.size() == b.size());
  for (std::size_t i = 0; i < a.size(); ++i) CHECK(a[i].X_WS.isApprox(b[i].X_WS, 0.0));
}

TEST_CASE("rooms with somebody in them have every stance, and nobody reaches into the object", "[stances]") {
  std::set<Stance> seen;
  int empty = 0;
  constexpr int kRooms = 200;
  for (std::uint64_t seed = 1; seed <= kRooms; ++seed) {
    const RandomRoom room = make_occupied_room(seed);
    empty += room.stance ? 0 : 1;
    if (!room.stance) continue;
    seen.insert(*room.stance);
    for (const Shape& part : room.world.shapes) {
      if (part.label != Label::Partner) continue;
      INFO(room.name);
      CHECK(distance(room.world, Label::Target, part.X_WS.translation()) > part.size[0]);
    }
  }
  CHECK(seen.size() == kStances.size());
  CHECK(empty < kRooms / 5);
}

}  // namespace colift::sim_hal
