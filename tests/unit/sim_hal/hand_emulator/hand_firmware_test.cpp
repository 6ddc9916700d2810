// The emulated pucks, asked byte by byte.
#include <catch2/catch.hpp>
#include <cmath>
#include <initializer_list>
#include <optional>
#include <vector>

#include "sim_hal/emulator/hand_light_plant.hpp"
#include "sim_hal/emulator/hand_lock_step.hpp"

using namespace colift;
using namespace colift::sim_hal;
using namespace std::chrono_literals;

namespace {

constexpr int kF1 = 0x00b, kF2 = 0x00c, kF3 = 0x00d, kSpreadId = 0x00e, kHand = 0x405;

struct Bus {
  hal::ManualClock clock;
  MemoryCan bus{clock};
  std::unique_ptr<MemoryCan::Node> far_end = bus.node(), client = bus.node();
  LightHandPlant plant;
  HandEmulator hand;
  std::vector<hal::CanFrame> heard;

  explicit Bus(HandEmulatorConfig config = awake()) : hand(std::move(config), plant, *far_end) {
    REQUIRE(far_end->open());
    REQUIRE(client->open());
    REQUIRE(hand.start(clock.now()));
  }
  static HandEmulatorConfig awake() {
    HandEmulatorConfig c;
    c.puck.awake = true;
    return c;
  }
  void pass(hal::Duration by) {
    run_until(hand, clock, clock.now() + by);
    hal::CanFrame f;
    while (client->receive(f, 0ns) == hal::CanBus::Received::Frame) heard.push_back(f);
  }
  void say(int id, std::initializer_list<int> bytes) {
    hal::CanFrame f;
    f.id = static_cast<std::uint16_t>(id);
    for (const int b : bytes) f.data[f.length++] = static_cast<std::uint8_t>(b);
    (void)client->send(f);
  }
  void set(int id, int property, int value) {
    say(id, {0x80 | property, 0, value & 255, value >> 8 & 255, value >> 16 & 255, value >> 24 & 255});
    pass(300us);
  }
  std::vector<hal::CanFrame> ask(int id, int property, hal::Duration patience = 3ms) {
    pass(0ns);
    heard.clear();
    say(id, {property});
    pass(patience);
    return heard;
  }
  std::optional<int> value(int id, int property) {
    const auto f = ask(id, property);
    if (f.empty()) return std::nullopt;
    REQUIRE(f.size() == 1);
    int v = f[0].data[2] | f[0].data[3] << 8;
    return f[0].length == 6 ? v | f[0].data[4] << 16 | f[0].data[5] << 24 : static_cast<std::int16_t>(v);
  }
  int position(std::size_t p) { return hand.puck(p).position(); }
  int mode(int id) { return value(id, prop::kMode).value_or(-1); }
};

}  // namespace

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

TEST_CASE("a full stroke takes as long as the drive's figures say", "[hand][emulator]") {
  Bus b;
  b.set(kF1, prop::kE, 195000);
  b.set(kF1, prop::kMode, 5);
  const hal::Timestamp start = b.clock.now();
  while (b.hand.puck(0).value(prop::kMode) == 5 && b.clock.now() - start < 5s) b.pass(1ms);
  CHECK(hal::seconds(b.clock.now() - start) == Approx(1.23).margin(0.03));
  CHECK(b.position(0) == 195000);
  CHECK(b.mode(kF1) == 0);
  // both joints: 2.393 rad inner, a third of it outer
  CHECK(b.plant.joint(0).joint == Approx(195000 / 2.5).margin(1));

  b.set(kSpreadId, prop::kM, 35900);
  const hal::Timestamp turn = b.clock.now();
  while (b.hand.puck(3).value(prop::kMode) == 5 && b.clock.now() - turn < 5s) b.pass(1ms);
  CHECK(hal::seconds(b.clock.now() - turn) == Approx(0.78).margin(0.03));
  CHECK(b.mode(kSpreadId) == 3);  // HOLD is 1
  CHECK(b.hand.report().times(HandRule::FingersInTheWay) == 1);
}

TEST_CASE("initialising: silence, the way to the stop, zero", "[hand][emulator]") {
  Bus b;
  b.plant.place(0, 150'000);
  b.set(kF1, prop::kHold, 1);
  b.set(kF1, prop::kCmd, 13);
  b.pass(400ms);
  CHECK(b.ask(kF1, prop::kMode).empty());
  b.pass(300ms);
  CHECK(b.mode(kF1) == 5);
  b.pass(1s);
  CHECK(b.mode(kF1) == 5);  // 150 000 counts at 75 a millisecond
  b.pass(500ms);
  CHECK(b.mode(kF1) == 3);
  CHECK(b.position(0) == 0);
  CHECK(b.plant.joint(0).motor == Approx(0).margin(0.1));
}

TEST_CASE("what a client should not do is counted", "[hand][emulator]") {
  Bus b;
  b.set(kF1, prop::kCmd, 18);
  b.pass(300ms);
  b.set(kF1, prop::kE, 10'000);
  CHECK(b.hand.report().times(HandRule::NewEnd) == 1);
  b.set(kF1, prop::kMode, 0);
  b.set(kF1, prop::kE, 20'000);
  CHECK(b.hand.report().times(HandRule::NewEnd) == 1);
  b.set(kF1, prop::kMt, 6000);
  CHECK(b.hand.report().times(HandRule::TooMuchTorque) == 1);
  b.set(kF2, prop::kMode, 4);
  CHECK(b.hand.report().times(HandRule::StreamWithStop) == 1);
  b.say(kF2, {0x80 | prop::kMode, 0, 0, 0});
  b.say(kF2, {0x80 | prop::kMode, 0, 0, 0});
  b.pass(1ms);
  CHECK(b.hand.report().times(HandRule::Hurried) == 1);
  CHECK_FALSE(b.hand.report().first[static_cast<std::size_t>(HandRule::Hurried)].empty());
}

TEST_CASE("blocked: TSTOP ends the move; 0 lets it press", "[hand][emulator]") {
  Bus b;
  b.plant.put(HandObject::of_width(0.1));
  b.set(kF1, prop::kTstop, 100);
  b.set(kF1, prop::kCmd, 18);
  b.pass(1500ms);
  CHECK(b.mode(kF1) == 0);
  const int stalled = b.position(0);
  CHECK(stalled > 80'000);
  CHECK(stalled < 100'000);
  CHECK(b.value(kF1, prop::kSg) > 2500);
  CHECK(b.value(kF1, prop::kT) == 0);
  b.set(kF1, prop::kMt, 1100);
  b.set(kF1, prop::kTstop, 0);
  b.set(kF1, prop::kMode, 5);
  b.pass(1s);
  CHECK(b.mode(kF1) == 5);
  CHECK(b.position(0) == stalled);  // a worm is never turned back
  CHECK(b.value(kF1, prop::kT) == 1100);
  CHECK(b.value(kF1, prop::kImotor) > 2200);
}

TEST_CASE("a strain limit stops a closing finger, and the gauge protects itself", "[hand][emulator]") {
  Bus b;
  b.plant.put(HandObject::of_width(0.1));
  b.set(kF1, prop::kMt, 5000);
  b.set(kF1, prop::kTstop, 0);
  SECTION("HSG") {
    b.set(kF1, prop::kHsg, 2500);
    b.set(kF1, prop::kCmd, 18);
    b.pass(1500ms);
    CHECK(b.mode(kF1) == 0);
    CHECK(b.value(kF1, prop::kSg).value() >= 2500);
    CHECK(b.value(kF1, prop::kSg).value() < 3000);
  }
  SECTION("by itself") {
    b.set(kF1, prop::kCmd, 18);
    b.pass(1500ms);
    CHECK(b.mode(kF1) == 0);
    CHECK(b.value(kF1, prop::kSg).value() >= 3460);
  }
  SECTION("switched off") {
    b.set(kF1, prop::kHsg, 10000);
    b.set(kF1, prop::kCmd, 18);
    b.pass(1500ms);
    CHECK(b.mode(kF1) == 5);
  }
}

TEST_CASE("speed, position and torque modes, streams and stops", "[hand][emulator]") {
  Bus b;
  b.set(kF2, prop::kTstop, 0);
  b.set(kF2, prop::kV, 100);
  b.set(kF2, prop::kMode, 4);
  b.pass(500ms);
  CHECK(b.position(1) == Approx(50'000).epsilon(0.02));
  CHECK(b.value(kF2, prop::kV) == 100);
  b.pass(3s);
  CHECK(b.position(1) == 195'000);  // CT
  b.set(kF2, prop::kMode, 3);
  b.set(kF2, prop::kP, 190'000);
  b.pass(300ms);
  CHECK(b.position(1) == Approx(190'000).margin(3));
  b.set(kF2, prop::kT, -1000);
  b.set(kF2, prop::kMode, 2);
  b.pass(100ms);
  CHECK(b.position(1) < 185'000);
  b.set(kF2, prop::kCmd, 21);
  b.pass(1ms);
  const int here = b.position(1);
  b.pass(100ms);
  CHECK(b.position(1) == here);
  b.set(kF2, prop::kP, 5);  // idle: from now on this is 5
  CHECK(b.position(1) == 5);
  CHECK(b.hand.report().times(HandRule::StreamWithStop) == 0);
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

TEST_CASE("heat takes the torque away", "[hand][emulator]") {
  Bus b;
  auto hot = parse_hand_fault("0:hot=60@F1:5");
  REQUIRE(hot);
  b.hand.inject(*hot);
  b.pass(2ms);
  CHECK(b.value(kF1, prop::kTemp) == 60);
  b.set(kF1, prop::kCmd, 18);
  b.set(kF2, prop::kCmd, 18);
  b.pass(1s);
  CHECK(b.position(0) == 0);
  CHECK(b.position(1) > 100'000);
  // half of it 8 degrees below OTEMP
  auto warm = parse_hand_fault("0:hot=52@F3:10");
  REQUIRE(warm);
  b.hand.inject(*warm);
  b.plant.put(HandObject::of_width(0.1));
  b.set(kF3, prop::kTstop, 0);
  b.set(kF3, prop::kMt, 2000);
  b.set(kF3, prop::kCmd, 18);
  b.pass(1500ms);
  CHECK(std::abs(b.value(kF3, prop::kT).value_or(0) - 1000) < 5);
}

TEST_CASE("pressing for minutes makes a puck warm", "[hand][emulator]") {
  Bus b;
  b.plant.put(HandObject::of_width(0.1));
  b.set(kF1, prop::kTstop, 0);
  b.set(kF1, prop::kCmd, 18);
  const int before = b.value(kF1, prop::kTherm).value();
  b.pass(120s);
  CHECK(b.value(kF1, prop::kTherm).value() > before + 15);
}

TEST_CASE("a reset loses zero and settings, and what was saved is back", "[hand][emulator]") {
  Bus b;
  b.set(kF1, prop::kCmd, 19);
  b.pass(1s);
  CHECK(b.position(0) == 45000);
  b.set(kF1, prop::kMv, 120);
  b.set(kF1, prop::kMt, 1500);
  b.set(kF1, prop::kSave, prop::kMv);
  b.set(kF1, prop::kCmd, 2);
  CHECK(b.value(kF1, prop::kStat) == 0);
  b.set(kF1, prop::kStat, 2);
  b.pass(1s);
  CHECK(b.value(kF1, prop::kMv) == 120);
  CHECK(b.value(kF1, prop::kMt) == 2200);
  CHECK(b.position(0) == 0);
}

TEST_CASE("a supply that is too weak resets all four", "[hand][emulator]") {
  HandEmulatorConfig c = Bus::awake();
  c.brown_out_units = 5000;
  Bus b{c};
  b.plant.put(HandObject::of_width(0.1));
  for (const int id : {0x00b, 0x00c, 0x00d}) {
    b.set(id, prop::kTstop, 0);
    b.set(id, prop::kCmd, 18);
  }
  b.pass(2s);
  for (std::size_t p = 0; p < 4; ++p) CHECK_FALSE(b.hand.puck(p).ready());
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
