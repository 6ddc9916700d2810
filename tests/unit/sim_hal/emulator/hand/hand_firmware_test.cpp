// The emulated pucks, asked byte by byte.
#include <catch2/catch.hpp>
#include <cmath>

#include "puck_bus.hpp"

using namespace colift;

TEST_CASE("a puck in its monitor tells who it is and nothing else; waking takes its time",
          "[hand][emulator]") {
  Bus b{HandEmulatorConfig{}};
  CHECK(b.value(kF1, prop::kStat) == 0);
  CHECK(b.value(kF1, prop::kRole) == 0x1e05);
  CHECK(b.value(kF1, prop::kVers) == 200);
  CHECK_FALSE(b.value(kF1, prop::kMode));
  CHECK(b.ask(kHand, prop::kP).empty());
  b.set(kF1, prop::kMt, 1);  // not taken
  b.set(0x400, prop::kStat, 2);
  b.pass(850ms);
  CHECK_FALSE(b.value(kF1, prop::kStat));
  CHECK(b.hand.report().times(HandRule::Unacknowledged) == 1);
  b.pass(100ms);
  CHECK(b.value(kF1, prop::kStat) == 2);
  CHECK(b.value(kF1, prop::kMt) == 2200);
}

TEST_CASE("without initialising, zero is where the fingers stood when power came", "[hand][emulator]") {
  Bus b{HandEmulatorConfig{}};
  b.plant.place(0, 90'000);
  REQUIRE(b.hand.start(b.clock.now()));
  b.set(0x400, prop::kStat, 2);
  b.pass(1s);
  CHECK(b.position(0) == 0);
  b.set(kF1, prop::kCmd, 13);
  b.pass(2500ms);
  CHECK(b.position(0) == 0);
  CHECK(b.plant.joint(0).motor == Approx(0).margin(0.1));
}

TEST_CASE("newer firmware wakes by itself", "[hand][emulator]") {
  HandEmulatorConfig c;
  c.puck.auto_ready_s = 2.0;
  Bus b{c};
  b.pass(1900ms);
  CHECK(b.value(kF1, prop::kStat) == 0);
  b.pass(200ms);
  CHECK(b.value(kF1, prop::kStat) == 2);
}

TEST_CASE("one question to the group is answered by all four, the lowest number first if all are ready",
          "[hand][emulator]") {
  HandEmulatorConfig c = Bus::awake();
  c.jitter = 0ns;
  Bus b{c};
  const auto p = b.ask(kHand, prop::kP);
  REQUIRE(p.size() == 4);
  const std::vector<int> ids{0x563, 0x583, 0x5a3, 0x5c3};
  for (std::size_t i = 0; i < 4; ++i) {
    CHECK(p[i].id == ids[i]);
    CHECK(p[i].length == (i < 3 ? 6 : 3));
    CHECK((p[i].data[0] & 0xc0) == 0x80);
  }
  CHECK(p[3].arrived_at - p[0].arrived_at > 250us);  // one after the other
  CHECK(p[3].arrived_at - p[0].arrived_at < 500us);
  // from another node than 0: to that node, P as any other
  const auto six = b.ask(0x0cb, prop::kP);
  REQUIRE(six.size() == 1);
  CHECK(six[0].id == 0x166);
  CHECK(six[0].length == 6);
}

TEST_CASE("what a puck does not know it passes over, and the emulator counts it", "[hand][emulator]") {
  Bus b;
  CHECK(b.ask(kF1, 123).empty());
  CHECK(b.ask(kF1, 49).empty());
  CHECK(b.ask(kF1, prop::kCmd).empty());
  CHECK(b.ask(0x014, prop::kStat).empty());
  b.set(kF1, 123, 5);
  b.set(kF1, prop::kTemp, 5);
  b.set(kF1, prop::kSave, -1);
  b.say(kF1, {0xb4, 0, 1});
  b.pass(1ms);
  const auto& r = b.hand.report();
  CHECK(r.times(HandRule::UnknownProperty) == 3);
  CHECK(r.times(HandRule::NotReadable) == 1);
  CHECK(r.times(HandRule::NotWritable) == 1);
  CHECK(r.times(HandRule::Risky) == 1);
  CHECK(r.times(HandRule::Malformed) == 1);
  CHECK(r.foreign == 1);
  CHECK(b.value(kF1, prop::kTemp) != 5);
}

TEST_CASE("four bytes and six bytes set the same, signs included", "[hand][emulator]") {
  Bus b;
  b.say(kF1, {0x80 | prop::kIvel, 0, 0xce, 0xff});
  b.pass(1ms);
  CHECK(b.value(kF1, prop::kIvel) == -50);
  b.set(kF1, prop::kIvel, -60);
  CHECK(b.value(kF1, prop::kIvel) == -60);
  b.say(kF1, {0x80 | prop::kE, 0, 0xfe, 0xff});  // 16 bits for a 32-bit one
  b.pass(1ms);
  CHECK(b.value(kF1, prop::kE) == -2);
}

TEST_CASE("pads: set, asked, tared, off", "[hand][emulator]") {
  Bus b;
  b.plant.put(HandObject::of_width(0.1));
  b.set(kF1, prop::kCmd, 18);
  b.pass(1500ms);
  b.heard.clear();
  b.set(kF1, prop::kTact, 2);
  b.pass(10ms);
  CHECK(b.heard.empty());
  b.pass(20ms);
  REQUIRE(b.heard.size() == 5);
  double force = 0.0;
  for (std::size_t row = 0; row < 5; ++row) {
    const auto& f = b.heard[row];
    CHECK(f.id == 0x569);
    CHECK(f.data[0] >> 4 == static_cast<int>(row));
    for (std::size_t i = 0; i < 5 && 5 * row + i < kHandCells; ++i) {
      const std::size_t nibble = 1 + 3 * i;
      int v = 0;
      for (std::size_t n = nibble; n < nibble + 3; ++n)
        v = v << 4 | (n % 2 == 0 ? f.data[n / 2] >> 4 : f.data[n / 2] & 15);
      force += v / 256.0 * hand_cell_cm2(false, 5 * row + i);
    }
  }
  CHECK(force == Approx(b.plant.joint(0).strain_nm / 0.05).epsilon(0.02));
  CHECK(b.ask(kF1, prop::kTact, 30ms).size() == 5);
  b.set(kF1, prop::kTact, 1);
  CHECK(b.ask(kF1, prop::kTact, 30ms).at(0).id == 0x568);
  b.set(kF1, prop::kTact, 3);
  const auto tared = b.ask(kF1, prop::kTact, 30ms);
  REQUIRE(tared.size() == 1);
  for (std::size_t i = 3; i < 8; ++i) CHECK(tared[0].data[i] == 0);
  b.set(kF1, prop::kTact, 0);
  b.pass(50ms);
  b.heard.clear();
  b.pass(100ms);
  CHECK(b.heard.empty());
}

TEST_CASE("a hand without the tactile option has no pads to tell of", "[hand][emulator]") {
  HandEmulatorConfig config = Bus::awake();
  config.puck.finger_role = config.puck.spread_role = 0x0605;
  Bus b(config);
  for (const int format : {1, 2}) {
    b.heard.clear();
    b.set(kF1, prop::kTact, format);
    b.pass(50ms);
    CHECK(b.heard.empty());
    const auto answers = b.ask(kF1, prop::kTact, 50ms);
    REQUIRE(answers.size() == 1);
    CHECK(answers[0].id == 0x566);  // a value as any other: off
    CHECK(answers[0].data[2] == 0);
  }
}

TEST_CASE("a fault is read or refused in words", "[hand][emulator]") {
  const auto f = parse_hand_fault("4.0:late=30@F2:1.5");
  REQUIRE(f);
  CHECK((f->at_s == 4.0 && f->value == 30.0 && f->puck == 1U && f->for_s == 1.5));
  CHECK(parse_hand_fault("1:reset@spread")->puck == 3U);
  // what a scenario may ask of a hand
  for (const char* action : {"freeze", "drop", "unplug", "corrupt", "late", "silent"})
    CHECK(hand_fault({2.0, "hand", action, 0.5}));
  CHECK(hand_fault({2.0, "hand", "blind", 0.5}).error().code == hal::ErrorCode::BadConfig);
  for (const char* text : {"", "x:silent", "-1:silent", "1:nothing", "1:silent@F5", "1:silent=3", "1:late=x",
                           "1:late=1e9", "1:silent:0", "1:bus-off@F1", "1"}) {
    const auto bad = parse_hand_fault(text);
    INFO(text);
    REQUIRE_FALSE(bad);
    CHECK(bad.error().code == hal::ErrorCode::BadInput);
  }
}

TEST_CASE("any bytes on the bus leave the pucks sane", "[hand][emulator][property]") {
  Bus b;
  std::uint32_t dice = 7;
  const auto next = [&] { return dice = dice * 1664525U + 1013904223U; };
  for (int i = 0; i < 20000; ++i) {
    hal::CanFrame f;
    f.id = static_cast<std::uint16_t>((next() >> 8) % 3 == 0 ? next() >> 16 & 0x7ff
                                                             : 0x00b + (next() >> 16) % 4);
    f.length = static_cast<std::uint8_t>((next() >> 16) % 9);
    for (auto& byte : f.data) byte = static_cast<std::uint8_t>(next() >> 16);
    (void)b.client->send(f);
    b.pass(200us);
    for (std::size_t p = 0; p < 4; ++p) {
      const double motor = b.plant.joint(p).motor;
      REQUIRE((motor >= 0.0 && motor <= kFingerStop));
    }
    b.heard.clear();
  }
}
