// A warm puck gives less torque than it is told, and says nothing about it.
#include "hand_rig.hpp"

namespace colift {

namespace {

constexpr int kTemp = 9, kTherm = 20, kMode = 8, kMt = 43;
constexpr std::int32_t kWarmHold = 500;

void heat(HandRig& rig, int celsius) {
  for (std::size_t i = 0; i < 3; ++i) rig.fake.pucks[i].property[kTemp] = celsius;
  rig.pass(std::chrono::milliseconds(1500));
}

/// Of the spread's motor, which fades no finger.
void heat_spread(HandRig& rig, int celsius) {
  rig.fake.pucks[3].property[kTherm] = celsius;
  rig.pass(std::chrono::milliseconds(1500));
}

}  // namespace

TEST_CASE("a grip with a tenth of its force is no grip", "[hand][faults]") {
  HandRig rig;
  rig.start();
  heat(rig, 58);
  rig.put_object(1.2);
  REQUIRE(rig.hand.close(0.8));
  CHECK_FALSE(rig.settle().held);
  CAPTURE(rig.why());
  CHECK(rig.why().find("holds with") != std::string::npos);
  CHECK(rig.why().find("at 58 C its puck gives 12 % of its torque") != std::string::npos);
}

TEST_CASE("a hand of an ordinary temperature grips", "[hand][faults]") {
  HandRig rig;
  rig.start();
  heat(rig, GENERATE(30, 44, 50));
  rig.grip();
}

TEST_CASE("the force that fades is told before it is gone", "[hand][faults]") {
  HandRig rig;
  rig.start();
  heat(rig, 43);
  CHECK(rig.hand.report().warning.empty());
  heat(rig, 48);
  CHECK(rig.hand.report().warning.str().find("its pucks give 75 % of their torque") != std::string::npos);
}

TEST_CASE("the limits of heat are those of the maker, and the warning comes before", "[hand][faults]") {
  const hal::BarrettHandConfig config;
  CHECK(config.warn_c == 60.0);
  CHECK(config.limit_c == 65.0);
  CHECK(config.warm_hold_torque_units == kWarmHold);
}

TEST_CASE("a grip is held with all its torque below 60 C, with less from 60 C, by its worms from 65 C",
          "[hand][faults]") {
  const int celsius = GENERATE(59, 60, 64, 65, 66);
  CAPTURE(celsius);
  HandRig rig;
  rig.start();
  rig.grip();
  rig.pass(std::chrono::milliseconds(200));
  const std::int32_t full = rig.fake.pucks[0].property[kMt];
  REQUIRE(full > kWarmHold);
  heat_spread(rig, celsius);
  const bool warm = celsius >= 60, hot = celsius >= 65;
  CHECK(rig.hand.report().warm == warm);
  CHECK(rig.hand.report().hot == hot);
  CHECK(rig.hand.report().warning.empty() == !warm);
  CHECK(rig.look().hot == hot);
  CHECK(rig.look().held);  // at any heat
  CHECK(rig.fake.pucks[0].position == Approx(1.2 * 81487.33).margin(100));
  for (std::size_t f = 0; f < 3; ++f) {
    CHECK(rig.fake.pucks[f].property[kMode] == (hot ? 0 : 5));
    if (!hot && warm) CHECK(rig.fake.pucks[f].property[kMt] == kWarmHold);
  }
  if (!warm) CHECK(rig.fake.pucks[0].property[kMt] == full);
}

TEST_CASE("an empty hand closes up to 64 C, and is refused at 65 C without a move", "[hand][faults]") {
  const int celsius = GENERATE(59, 60, 64, 65);
  CAPTURE(celsius);
  HandRig rig;
  rig.start();
  heat_spread(rig, celsius);
  rig.put_object(1.2);
  const std::size_t from = rig.fake.from_host.size();
  const auto closed = rig.hand.close(0.5);
  REQUIRE(closed.has_value() == (celsius < 65));
  if (closed) {
    CHECK(rig.settle().held);
    return;
  }
  CHECK(closed.error().code == hal::ErrorCode::DeviceFault);
  CHECK(closed.error().detail.find("the hand has 65 C (limit 65)") == 0);
  rig.pass(std::chrono::seconds(1));
  for (std::size_t f = 0; f < 3; ++f) {
    CHECK(rig.fake.sets(f, kMode, from) == 0);
    CHECK(rig.fake.pucks[f].position < 1.0);
  }
}

TEST_CASE("a limit of heat is left three degrees below it", "[hand][faults]") {
  HandRig rig;
  rig.start();
  struct {
    int celsius;
    bool warm, hot;
  } const course[] = {{64, true, false}, {65, true, true},   {62, true, true},  {61, true, false},
                      {57, true, false}, {56, false, false}, {59, false, false}};
  for (const auto& at : course) {
    CAPTURE(at.celsius);
    heat_spread(rig, at.celsius);
    CHECK(rig.hand.report().warm == at.warm);
    CHECK(rig.hand.report().hot == at.hot);
  }
}

TEST_CASE("the limits of heat are the configured ones, to a tenth of a degree", "[hand][faults]") {
  hal::BarrettHandConfig config;
  config.warn_c = 50.1;
  config.limit_c = 55.0;
  HandRig rig(config);
  rig.start();
  heat_spread(rig, 50);  // 0.1 C below
  CHECK_FALSE(rig.hand.report().warm);
  heat_spread(rig, 51);
  CHECK(rig.hand.report().warm);
  heat_spread(rig, 55);
  CHECK_FALSE(rig.hand.close(0.5));
}

TEST_CASE("a limit of heat that is no more than its warning is refused", "[hand][faults]") {
  for (const double limit_c : {60.0, 59.0}) {
    hal::BarrettHandConfig config;
    config.limit_c = limit_c;
    HandRig rig(config);
    const auto refused = rig.hand.configure();
    REQUIRE_FALSE(refused);
    CHECK(refused.error().code == hal::ErrorCode::BadConfig);
  }
}

}  // namespace colift
