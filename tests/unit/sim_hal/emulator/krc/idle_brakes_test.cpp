// Brakes that close by themselves while nothing moves, and what opens them.
#include <catch2/catch.hpp>

#include "fri_peer.hpp"

using namespace colift;
using namespace colift::sim_hal;
using test::Bench;
using test::Seen;

namespace {

KrcConfig idle(const char* script, bool start_opens = true) {
  KrcConfig c;
  c.script = script;
  c.idle_brakes_s = 2.0;
  c.start_opens_brakes = start_opens;
  return c;
}

bool off(const Seen& m) {
  return m.power() == 0;
}

}  // namespace

TEST_CASE("in a pause of the program the brakes close, and the drives are off", "[krc]") {
  Bench b(idle("stanford"));
  REQUIRE(b.krc->start(b.clock.now()));
  b.turns(900);
  CHECK(b.last.power() == 0x7F);
  REQUIRE(b.until(off, 200));
  CHECK(b.last.state() == 1);
  CHECK(b.last.get<std::uint16_t>(184) == 0);  // no error
  CHECK(b.was_told("the brakes closed: nothing moved for 2 s"));
  CHECK((b.last.q_total() - b.last.q()).norm() < 1e-3);
  b.turns(500);
  CHECK(b.last.state() == 1);
  CHECK(b.broken().empty());
}

TEST_CASE("friStart opens them: command mode comes before the drives do", "[krc]") {
  Bench b(idle("stanford"));
  REQUIRE(b.krc->start(b.clock.now()));
  REQUIRE(b.until(off, 1500));
  b.from_int[14] = 30;
  b.from_int[15] = 10;
  REQUIRE(b.until([](const Seen& m) { return m.state() == 2; }, 1500));
  CHECK(b.last.power() == 0);
  REQUIRE(b.until([](const Seen& m) { return m.power() == 0x7F; }, 200));
  CHECK(b.last.state() == 2);
  b.turns(2000);  // command mode is no pause
  CHECK(b.last.state() == 2);
  CHECK(b.last.power() == 0x7F);
  CHECK(b.broken().empty());
}

TEST_CASE("where only a motion opens them a program without one does not start", "[krc]") {
  Bench b(idle("stanford", false));
  REQUIRE(b.krc->start(b.clock.now()));
  REQUIRE(b.until(off, 1500));
  b.from_int[14] = 30;
  b.from_int[15] = 10;
  REQUIRE(b.until([](const Seen& m) { return m.to_int(15) == 20; }, 1500));
  CHECK(b.last.state() == 1);
  CHECK(b.was_told("no motion opened them"));
}

TEST_CASE("TUM's program moves every 3 s and keeps its drives on", "[krc]") {
  KrcConfig c = idle("tum");
  c.idle_brakes_s = 4.0;
  Bench b(c);
  REQUIRE(b.krc->start(b.clock.now()));
  for (int i = 0; i < 5000; ++i) {
    b.turn();
    REQUIRE(b.last.power() == 0x7F);
  }
}

TEST_CASE("an emergency stop while the brakes are closed is one: the program halts, and moves nothing",
          "[krc]") {
  Bench b(idle("tum"));
  REQUIRE(b.krc->start(b.clock.now()));
  REQUIRE(b.until(off, 1500));
  b.krc->inject(parse_krc_fault(std::to_string(hal::seconds(b.clock.now())) + ":estop:1").value());
  b.turns(2000);
  CHECK(b.last.power() == 0);
  CHECK(b.was_told("fault ends"));
  CHECK_FALSE(b.was_told("no motion while the drives are off"));  // nobody asked for one
}
