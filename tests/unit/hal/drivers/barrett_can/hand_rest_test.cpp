// What presses on when nobody is there any more, and what is read back at the end.
#include "hand_rig.hpp"

using namespace colift;
using namespace std::chrono_literals;
using Catch::Matchers::Contains;

TEST_CASE("a program that dies leaves no motor on: the pucks end the pressing by themselves",
          "[hand][rest]") {
  HandRig rig;
  rig.start();
  rig.grip();
  rig.pass(5s);  // while it lives it presses
  for (std::size_t f = 0; f < 3; ++f) CHECK(rig.fake.pucks[f].mode() == 5);
  CHECK(rig.look().held);
  const double at = rig.fake.pucks[0].position;
  rig.fake.pass(1200ms);  // killed: nobody says anything
  for (std::size_t f = 0; f < 3; ++f) CHECK(rig.fake.pucks[f].mode() == 0);
  CHECK(rig.fake.pucks[0].position == at);  // its worm holds
}

TEST_CASE("at the end it is told what was read back of each motor", "[hand][rest]") {
  HandRig rig;
  rig.start();
  rig.grip();
  const auto modes = [&] { return rig.hand.report().mode_at_rest; };
  SECTION("all rest, the loaded spread keeps its angle") {
    rig.hand.deactivate();
    CHECK(modes() == std::array<std::optional<std::int32_t>, 4>{0, 0, 0, 3});
    CHECK(motors_at_rest(rig.hand.report()) ==
          "motors at rest, as read back: F1, F2, F3; keeps its angle: spread");
    CHECK(fingers_rest(rig.hand.report()));
  }
  SECTION("the command gets lost twice") {
    int left = 2;
    rig.fake.bus.fate = [left](const hal::CanFrame& f, const auto*) mutable {
      const bool idle = f.id == 0x00c && f.data[0] == 0x88 && f.data[2] == 0;
      return sim_hal::MemoryCan::Fate{idle && left-- > 0 ? 0 : 1, f.id > 0x500 ? 150us : 0us};
    };
    rig.hand.deactivate();
    CHECK(rig.fake.pucks[1].mode() == 0);
    CHECK(fingers_rest(rig.hand.report()));
  }
  SECTION("one does not take it") {
    rig.fake.bus.fate = [](const hal::CanFrame& f, const auto*) {
      const bool idle = f.id == 0x00c && f.data[0] == 0x88 && f.data[2] == 0;
      return sim_hal::MemoryCan::Fate{idle ? 0 : 1, f.id > 0x500 ? 150us : 0us};
    };
    rig.hand.deactivate();
    CHECK(modes() == std::array<std::optional<std::int32_t>, 4>{0, 5, 0, 3});
    CHECK_THAT(motors_at_rest(rig.hand.report()), Contains("STILL ON: F2 (MODE 5)"));
    CHECK_FALSE(fingers_rest(rig.hand.report()));
  }
  SECTION("one says nothing") {
    rig.fake.pucks[2].silent = true;
    const hal::Timestamp began = rig.clock.now();
    rig.hand.deactivate();
    CHECK(rig.clock.now() - began <= 110ms);
    CHECK(modes() == std::array<std::optional<std::int32_t>, 4>{0, 0, std::nullopt, 3});
    CHECK_THAT(motors_at_rest(rig.hand.report()), Contains("not read back, unknown: F3"));
    CHECK_FALSE(fingers_rest(rig.hand.report()));
  }
}

TEST_CASE("a puck that another program left pressing is named by the next start", "[hand][rest]") {
  HandRig rig;
  rig.start();
  rig.grip();
  hal::BarrettHand next(*rig.fake.host, rig.config, rig.clock);  // the first one was killed
  REQUIRE(next.configure());
  CHECK(next.report().loaded);
  CHECK_THAT(next.report().remark.str(),
             Contains("motors on, left so by another program: F1 (MODE 5), F2 (MODE 5), F3 (MODE 5)"));
}
