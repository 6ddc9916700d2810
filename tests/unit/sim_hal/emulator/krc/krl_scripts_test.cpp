#include <catch2/catch.hpp>

#include "fri_peer.hpp"

using namespace colift;
using namespace colift::sim_hal;
using test::Bench;
using test::Seen;

namespace {

KrcConfig with(const char* script) {
  KrcConfig c;
  c.script = script;
  return c;
}

bool commands(const Seen& m) {
  return m.state() == 2;
}

}  // namespace

TEST_CASE("TUM's program takes requests with a bit and answers with a bit", "[krc]") {
  Bench b(with("tum"));
  REQUIRE(b.krc->start(b.clock.now()));
  b.turns(400);
  CHECK(b.last.control() == 3);
  const auto request = [&](std::int32_t what) {
    b.from_int[0] = what;
    b.from_bool = 1;
    REQUIRE(b.until([](const Seen& m) { return (m.get<std::uint16_t>(136) & 1) != 0; }, 100));
    b.from_bool = 0;
    REQUIRE(b.until([](const Seen& m) { return (m.get<std::uint16_t>(136) & 1) == 0; }, 500));
    b.from_int[0] = 0;
  };
  request(1);
  REQUIRE(b.until(commands, 200));
  b.from_bool |= 0x80;
  b.turns(50);
  request(2);
  REQUIRE(b.until([](const Seen& m) { return m.state() == 1; }, 200));
  b.from_int[1] = 4;
  request(3);
  CHECK(b.last.get<float>(148) == 0.004f);
  CHECK(b.was_told("friOpen(4)"));
  b.turns(250);
  request(1);
  CHECK(b.until(commands, 300));
  CHECK(b.broken().empty());
}

TEST_CASE("TUM's program does not start while something pushes the tool", "[krc]") {
  KrcConfig config = with("tum");
  config.faults.push_back(parse_krc_fault("0.2:contact=12:100").value());
  Bench b(config);
  REQUIRE(b.krc->start(b.clock.now()));
  b.turns(400);
  b.from_int[0] = 1;
  b.from_bool = 1;
  CHECK_FALSE(b.until(commands, 500));
  CHECK(b.was_told("KRL: no start: 12.0 N"));
}

TEST_CASE("the vendor's program starts at 10, is mirrored, and ends by itself with -1", "[krc]") {
  KrcConfig config = with("vendor");
  config.program.runs_s = 1.0;
  config.program.linger_s = 0.5;
  Bench b(config);
  REQUIRE(b.krc->start(b.clock.now()));
  b.flags = 0x1;
  b.from_int[0] = 1;
  REQUIRE(b.until([](const Seen& m) { return m.quality() >= 2; }));
  CHECK(b.last.state() == 1);
  b.from_int[0] = 10;
  REQUIRE(b.until(commands, 500));
  CHECK(b.last.control() == 1);
  REQUIRE(b.until([](const Seen& m) { return m.to_int(0) == -1; }, 700));
  CHECK(b.last.state() == 1);
  CHECK(b.last.get<float>(12) > 1.0f);  // $FRI_TO_REA[2] counts
  while (b.turn()) {
  }
  CHECK(b.krc->ended());
  CHECK(b.broken().empty());
}

TEST_CASE("CentroEPiaggio's program keeps position control for its first start", "[krc]") {
  Bench b(with("cep"));
  REQUIRE(b.krc->start(b.clock.now()));
  b.turns(30);
  CHECK(b.last.to_int(1) == 10);
  b.flags = 0x1;
  b.from_int[0] = 30;
  b.from_int[1] = 1;
  REQUIRE(b.until(commands));
  CHECK(b.last.control() == 1);
  REQUIRE(b.until([](const Seen& m) { return m.to_int(1) == 1; }, 100));
  b.from_int[1] = 0;
  REQUIRE(b.until([](const Seen& m) { return m.to_int(1) == 0; }, 500));
  b.flags = 0x35;
  b.from_int[1] = 1;
  REQUIRE(b.until(commands));
  CHECK(b.last.control() == 3);
}

namespace {

/// The client's half of CoLift's own hand-shake.
struct Colift : Bench {
  explicit Colift(KrcConfig config = with("colift")) : Bench(std::move(config)) {
    REQUIRE(krc->start(clock.now()));
    from_int[0] = 10001;
    REQUIRE(turn_beats([](const Seen& m) { return m.to_int(0) == 10001; }));
    from_int[3] = last.to_int(3);
  }
  template <class Done>
  bool turn_beats(Done done, int most = 4000) {
    for (int i = 0; i < most; ++i) {
      if (beats && ++cycles % 25 == 0) from_int[4] = from_int[4] % 30000 + 1;
      const auto m = turn();
      if (m && done(*m)) return true;
    }
    return false;
  }
  /// A request and its result.
  int ask(std::int32_t request, std::int32_t strategy = 0) {
    from_int[1] = request;
    from_int[2] = strategy;
    from_int[3] = from_int[3] % 30000 + 1;
    const std::int32_t number = from_int[3];
    if (!turn_beats([&](const Seen& m) { return m.to_int(3) == number && m.to_int(5) != 0; })) return -1;
    return last.to_int(5);
  }
  int cycles = 0;
  bool beats = true;
};

}  // namespace

TEST_CASE("CoLift's program starts, stops and closes by number", "[krc]") {
  Colift b;
  CHECK(b.last.to_int(1) == 1);
  CHECK(b.ask(1, 30) == 1);
  CHECK(b.last.state() == 2);
  CHECK(b.last.to_int(1) == 3);
  CHECK(b.last.to_int(2) == 30);
  CHECK(b.ask(1, 30) == 1);  // already there
  CHECK(b.ask(1, 10) == 3);  // not while commanding
  CHECK(b.last.state() == 2);
  CHECK(b.ask(2) == 1);
  CHECK(b.last.state() == 1);
  CHECK(b.last.to_int(1) == 1);
  b.flags = 0x1;
  CHECK(b.ask(1, 10) == 1);
  CHECK(b.last.control() == 1);
  CHECK(b.ask(3) == 1);
  CHECK(b.last.to_int(1) == 5);
  CHECK(b.last.state() == 1);
  while (b.turn()) {
  }
  CHECK(b.krc->ended());
  CHECK(b.broken().empty());
}

TEST_CASE("CoLift's program says what was wrong with a request", "[krc]") {
  Colift b;
  CHECK(b.ask(1, 40) == 3);
  CHECK(b.ask(9) == 7);
  CHECK(b.ask(0) == 1);
  CHECK(b.ask(2) == 1);
  b.from_int[0] = 10002;
  CHECK(b.ask(1, 30) == 6);
  b.from_int[0] = 10001;
  b.flags = 0x3500;
  CHECK(b.ask(1, 30) == 4);
  CHECK(b.broken() == "flags-do-not-fit");
  CHECK(b.last.to_int(1) == 1);
}

TEST_CASE("CoLift's program waits 5 s for quality, and another request ends the wait", "[krc]") {
  KrcConfig config = with("colift");
  config.faults.push_back(parse_krc_fault("0:quality=bad:100").value());
  Colift b(config);
  const hal::Timestamp asked = b.clock.now();
  CHECK(b.ask(1, 30) == 2);
  CHECK(hal::seconds(b.clock.now() - asked) == Approx(5.0).margin(0.1));
  b.from_int[1] = 1;
  b.from_int[3] += 1;
  b.turn_beats([](const Seen& m) { return m.to_int(1) == 2; }, 100);
  CHECK(b.last.to_int(1) == 2);
  CHECK(b.ask(2) == 1);
  CHECK(b.last.to_int(1) == 1);
}

TEST_CASE("CoLift's program stops when the client's heartbeat does", "[krc]") {
  Colift b;
  CHECK(b.ask(1, 30) == 1);
  b.turn_beats([](const Seen&) { return false; }, 1000);
  CHECK(b.last.state() == 2);
  CHECK(b.last.to_int(4) > 0);
  b.beats = false;
  REQUIRE(b.turn_beats([](const Seen& m) { return m.state() == 1; }, 600));
  b.turns(20);
  CHECK(b.last.to_int(5) == 8);
  CHECK(b.last.to_int(1) == 1);
  CHECK(b.last.power() == 0x7F);
}

TEST_CASE("CoLift's program tells that command mode was lost", "[krc]") {
  Colift b;
  CHECK(b.ask(1, 30) == 1);
  b.say_nothing(6);
  b.turns(30);
  CHECK(b.last.to_int(5) == 5);
  CHECK(b.last.to_int(1) == 1);
}
