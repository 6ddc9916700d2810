// How hard the fingers press: never more than was wished at any of them, nor harder on the way to letting go.
#include <algorithm>
#include <utility>
#include <vector>

#include "hand_rig.hpp"

using namespace colift;
using namespace std::chrono_literals;
using Catch::Contains;

namespace {

constexpr int kMode = 8, kMt = 43, kE = 52, kHsg = 71;

/// The settings of one puck that the host sent from `from` on, as (property, value).
std::vector<std::pair<int, int>> settings(const HandRig& rig, std::size_t puck, std::size_t from) {
  std::vector<std::pair<int, int>> all;
  for (std::size_t i = from; i < rig.fake.from_host.size(); ++i) {
    const hal::CanFrame& f = rig.fake.from_host[i];
    if (f.id != 11 + puck || (f.data[0] & 0x80) == 0) continue;
    int value = static_cast<std::int8_t>(f.data[f.length - 1]);
    for (int b = f.length - 2; b >= 2; --b) value = value * 256 + f.data[static_cast<std::size_t>(b)];
    all.emplace_back(f.data[0] & 0x7f, value);
  }
  return all;
}

int last_of(const std::vector<std::pair<int, int>>& all, int property) {
  int value = -1;
  for (const auto& [p, v] : all)
    if (p == property) value = v;
  return value;
}

}  // namespace

TEST_CASE("who lets go does not press first: the motor is off before it gets another torque and another end",
          "[hand][pressure]") {
  HandRig rig;
  rig.start();
  rig.grip();
  const std::size_t from = rig.fake.from_host.size();
  REQUIRE(rig.hand.release());
  rig.settle();
  for (std::size_t f = 0; f < 3; ++f) {
    const auto all = settings(rig, f, from);
    REQUIRE_FALSE(all.empty());
    CHECK(all.front() == std::pair<int, int>{kMode, 0});
    const auto position = [&](int property, int value) {
      return std::find(all.begin(), all.end(), std::pair<int, int>{property, value}) - all.begin();
    };
    CHECK(position(kE, 0) < position(kMode, 5));
    CHECK(last_of(all, kMt) == 2200);
  }
}

TEST_CASE("F1 and F2 share what F3 bears, as far as they press against it", "[hand][pressure]") {
  const double spread_rad = GENERATE(0.0, 0.8, 1.5);
  HandRig rig;
  rig.start();
  REQUIRE(rig.hand.preshape(spread_rad));
  rig.settle();
  const std::size_t from = rig.fake.from_host.size();
  rig.put_object(1.2);
  REQUIRE(rig.hand.close(0.7));
  REQUIRE(rig.settle().held);
  const double part = spread_rad > 1.05 ? 1.0 : 0.5 / std::cos(spread_rad);
  const auto closing_mt = [&](std::size_t f) {
    for (const auto& [p, v] : settings(rig, f, from))
      if (p == kMt) return v;
    return 0;
  };
  CHECK(closing_mt(2) == Approx(0.7 * 2900).margin(2));
  for (std::size_t f = 0; f < 2; ++f) CHECK(closing_mt(f) == Approx(part * 0.7 * 2900).epsilon(0.02));
}

TEST_CASE("a finger whose puck let off to protect its gauge rests on its worm, and presses again when it may",
          "[hand][pressure]") {
  HandRig rig;
  rig.start();
  rig.grip();
  FakePuck& f3 = rig.fake.pucks[2];
  f3.load_share = 3.5;
  rig.pass(50ms);
  f3.property[kMode] = 0;
  rig.pass(500ms);
  CHECK(rig.look().held);
  CHECK(f3.mode() == 0);
  for (int i = 0; i < 250; ++i) {
    f3.load_share -= 0.01;  // slowly: no slip
    rig.pass(10ms);
  }
  CHECK_FALSE(rig.look().slips);
  CHECK(rig.look().held);
  CHECK(f3.mode() == 5);
}

TEST_CASE("what slips is gripped up once, to the limit", "[hand][pressure][slip]") {
  HandRig rig;
  rig.start();
  rig.put_object(1.2);
  REQUIRE(rig.hand.close(0.3));
  REQUIRE(rig.settle().held);
  rig.pass(500ms);
  const std::size_t from = rig.fake.from_host.size();
  for (FakePuck& puck : rig.fake.pucks) puck.load_share = 0.3;
  CHECK(until(rig, 100ms, [&] { return rig.look().slips; }) <= 50ms);
  rig.pass(100ms);
  CHECK(rig.look().held);
  CHECK(last_of(settings(rig, 2, from), kMt) == 2200);
  CHECK(last_of(settings(rig, 2, from), kHsg) == 0);
  const std::size_t later = rig.fake.from_host.size();
  rig.pass(500ms);
  CHECK(last_of(settings(rig, 2, later), kMt) == -1);
}

TEST_CASE("the state says what control has to react to", "[hand][pressure]") {
  HandRig rig;
  rig.start();
  CHECK(rig.look().warning.empty());
  for (FakePuck& puck : rig.fake.pucks) puck.property[9] = 62;
  rig.pass(1s);
  CHECK_FALSE(rig.look().hot);
  CHECK_THAT(rig.look().warning.str(), Contains("62 C"));
  for (FakePuck& puck : rig.fake.pucks) puck.property[9] = 72;
  rig.pass(1s);
  CHECK(rig.look().hot);
  CHECK_THAT(rig.look().warning.str(), Contains("72 C"));
}
