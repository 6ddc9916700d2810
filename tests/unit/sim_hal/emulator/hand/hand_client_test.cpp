// The real driver, which shares no code with the emulator, at the other end of the bus.
#include <catch2/catch.hpp>
#include <cmath>
#include <string>

#include "tests/contract/barrett_rig.hpp"

using namespace colift;
using namespace std::chrono_literals;
using hal::ErrorCode;

namespace {

struct Rig : BarrettRig {
  explicit Rig(bool with_object = false, const hal::BarrettHandConfig& config = {},
               const sim_hal::HandEmulatorConfig& emulator = {})
      : BarrettRig(with_object, config, emulator) {}

  void start() {
    const auto done = hand->configure();
    INFO((done ? std::string() : done.error().text()));
    REQUIRE(done);
    REQUIRE(hand->activate());
  }
  hal::HandState look() {
    const auto state = hand->state();
    INFO((state ? std::string() : state.error().text()));
    REQUIRE(state);
    return *state;
  }
  hal::HandState settle() {
    for (int i = 0; i < 800 && look().moving; ++i) pass(10ms);
    REQUIRE_FALSE(look().moving);
    return look();
  }
  void grip() {
    REQUIRE(hand->close(0.6));
    const auto state = settle();
    INFO(driver->report().why.str());
    REQUIRE(state.held);
  }
  void fault(const char* text) {
    auto f = sim_hal::parse_hand_fault(text);
    REQUIRE(f);
    f->at_s += pucks.elapsed_s();
    pucks.inject(*f);
  }
  /// Until the driver reports a fault.
  hal::Error reported_fault(hal::Duration limit) {
    const hal::Timestamp end = clock.now() + limit;
    for (;;) {
      const auto state = hand->state();
      if (!state) return state.error();
      REQUIRE(clock.now() < end);
      pass(1ms);
    }
  }
};

}  // namespace

TEST_CASE("the driver wakes, identifies and initialises the pucks and breaks no rule on the way",
          "[hand][emulator]") {
  Rig rig;
  for (std::size_t f = 0; f < 3; ++f) rig.plant.place(f, 60'000 + 20'000.0 * static_cast<double>(f));
  rig.plant.place(3, 9'000);
  const hal::Timestamp before = rig.clock.now();
  rig.start();
  const double took_s = hal::seconds(rig.clock.now() - before);
  // a second of booting, 100 000 counts at 75 a millisecond, the spread's second of silence
  CHECK(took_s > 1.0 + 1.33 + 1.0);
  CHECK(took_s < 6.0);
  for (std::size_t p = 0; p < 4; ++p) {
    CHECK(rig.pucks.report().initialised[p] == 1);
    CHECK(rig.plant.joint(p).motor == Approx(0.0).margin(1.0));
    CHECK(rig.pucks.puck(p).position() == 0);
  }
  for (std::size_t r = 0; r < sim_hal::kHandRules; ++r) {
    INFO(sim_hal::kHandRuleNames[r] << ": " << rig.pucks.report().first[r]);
    CHECK(rig.pucks.report().broken[r] == 0);
  }
}

TEST_CASE("preshape, close on an object, hold, release", "[hand][emulator]") {
  Rig rig(true);
  rig.start();
  REQUIRE(rig.hand->preshape(0.5));
  CHECK(rig.settle().spread_rad == Approx(0.5).margin(0.01));
  REQUIRE(rig.hand->close(0.6));
  rig.pass(200ms);
  CHECK(rig.look().moving);
  CHECK_FALSE(rig.look().held);
  const auto held = rig.settle();
  INFO(rig.driver->report().why.str());
  REQUIRE(held.held);
  // 0.1 m between the pads: 64 degrees of the inner link by the maker's table
  for (std::size_t f = 0; f < 3; ++f) {
    CHECK(held.finger_rad[f] == Approx(1.06).margin(0.08));
    CHECK(held.outer_rad[f] == Approx(held.finger_rad[f] / 3.0).margin(0.01));
    CHECK(held.torque_nm[f] > 0.25);
    CHECK(held.torque_nm[f] < 0.8);
    CHECK(held.tip_force_n[f] == Approx(held.torque_nm[f] / 0.05).epsilon(0.1));
  }
  rig.pass(3s);
  CHECK(rig.look().held);
  CHECK(std::abs(rig.look().finger_rad[0] - held.finger_rad[0]) < 0.01);
  CHECK(rig.hand->preshape(0.0).error().code == ErrorCode::NotReady);
  REQUIRE(rig.hand->release());
  const auto open = rig.settle();
  for (const double angle : open.finger_rad) CHECK(std::abs(angle) < 0.01);
  CHECK_FALSE(rig.driver->report().loaded);
  for (std::size_t r = 0; r < sim_hal::kHandRules; ++r) {
    INFO(sim_hal::kHandRuleNames[r] << ": " << rig.pucks.report().first[r]);
    CHECK(rig.pucks.report().broken[r] == 0);
  }
}

TEST_CASE("an object deep in the hand makes the clutches give way, and opening brings them back",
          "[hand][emulator]") {
  Rig rig;
  rig.start();
  sim_hal::HandObject deep;
  deep.inner_rad.fill(0.8);
  deep.total_rad.fill(1.6);
  rig.plant.put(deep);
  REQUIRE(rig.hand->preshape(1.2));  // no finger presses against another: each has all of the torque
  (void)rig.settle();
  REQUIRE(rig.hand->close(0.75));
  const auto held = rig.settle();
  INFO(rig.driver->report().why.str());
  REQUIRE(held.held);
  for (std::size_t f = 0; f < 3; ++f) {
    CHECK(rig.plant.broken_away(f));
    CHECK(rig.driver->report().broken_away[f]);
    CHECK(held.finger_rad[f] == Approx(0.84).margin(0.02));
    CHECK(held.outer_rad[f] > held.finger_rad[f] / 3.0 + 0.2);
  }
  REQUIRE(rig.hand->release());
  const auto open = rig.settle();
  for (std::size_t f = 0; f < 3; ++f) {
    CHECK_FALSE(rig.driver->report().broken_away[f]);
    CHECK(std::abs(open.finger_rad[f]) < 0.01);
  }
}

TEST_CASE("an object that leaves the grip is a slip within 50 ms", "[hand][emulator]") {
  Rig rig(true);
  rig.start();
  rig.grip();
  rig.pass(500ms);
  rig.plant.take_away();
  const hal::Timestamp gone = rig.clock.now();
  while (!rig.driver->report().slipped && rig.clock.now() - gone < 1s) rig.pass(1ms);
  CHECK(hal::seconds(rig.clock.now() - gone) < 0.05);
}

TEST_CASE("faults of single pucks are noticed", "[hand][emulator]") {
  Rig rig(true);
  rig.start();
  SECTION("silent") {
    rig.fault("0:silent@F2:2");
    const auto e = rig.reported_fault(200ms);
    CHECK(e.code == ErrorCode::LinkLost);
    CHECK(e.detail.find("F2") != std::string::npos);
    rig.pass(3s);
    CHECK(rig.hand->state());  // it is back
  }
  SECTION("reset while it holds") {
    rig.grip();
    rig.fault("0:reset@F1");
    const auto e = rig.reported_fault(200ms);
    CHECK(e.code == ErrorCode::DeviceFault);
    CHECK(rig.driver->report().zero_lost[0]);
    CHECK(rig.plant.joint(0).motor > 50'000);  // its worm holds
  }
  SECTION("in error") {
    rig.fault("0:error=7@F3");
    const auto e = rig.reported_fault(300ms);
    CHECK(e.code == ErrorCode::DeviceFault);
    rig.pass(50ms);
    CHECK(rig.hand->state().error().detail.find("7") != std::string::npos);
  }
  SECTION("an encoder that jumps") {
    rig.fault("0:jump=50000@F1");
    const auto e = rig.reported_fault(300ms);
    CHECK(e.code == ErrorCode::DeviceFault);
    CHECK(e.detail.find("jumped by 50000 counts without a reset") != std::string::npos);
  }
  SECTION("hot: it closes no more") {
    rig.fault("0:hot=80@F1:5");
    rig.pass(1s);
    CHECK(rig.driver->report().hot);
    CHECK(rig.hand->close(0.5).error().code == ErrorCode::DeviceFault);
    CHECK(rig.hand->state());
  }
  SECTION("a motor that does not turn leaves no grip") {
    rig.fault("0:stuck@F3:10");
    REQUIRE(rig.hand->close(0.6));
    CHECK_FALSE(rig.settle().held);
    CHECK(rig.driver->report().why.str().find("F3") != std::string::npos);
  }
}

TEST_CASE("answers that come late, twice, or under another name do not mislead", "[hand][emulator]") {
  Rig rig(true);
  rig.start();
  SECTION("twice: nothing happens") {
    rig.fault("0:duplicate:20");
    rig.grip();
    CHECK(rig.driver->health().rejected > 100);
  }
  SECTION("later than the deadline: waited for longer, and told") {
    rig.fault(GENERATE("0:late=20@F2:3", "0:late=30@F2:3", "0:late=30:3", "0:late=20:3"));
    bool well = true;
    rig.pass(2s, [&] { well = well && rig.hand->state(); });
    CHECK(well);
    CHECK(rig.hand->state()->warning.str().find("slow link") != std::string::npos);
    rig.grip();
  }
  SECTION("too late for anything: as if it were silent") {
    rig.fault("0:late=200@F2:0.5");
    CHECK(rig.reported_fault(200ms).code == ErrorCode::LinkLost);
    rig.pass(1s);
    CHECK(rig.hand->state());
  }
  SECTION("as another puck's") {
    rig.fault("0:wrong@F1:0.5");
    CHECK(rig.reported_fault(200ms).code == ErrorCode::LinkLost);
  }
  SECTION("one in a hundred lost") {
    rig.fault("0:loss=1:20");
    rig.grip();
    REQUIRE(rig.hand->release());
    rig.settle();
  }
}

TEST_CASE("a lost bus is told, and what was held stays held", "[hand][emulator]") {
  Rig rig(true);
  rig.start();
  rig.grip();
  const auto name = GENERATE("bus-off", "down");
  rig.fault((std::string("0:") + name + ":0.8").c_str());
  CHECK(rig.reported_fault(100ms).code == ErrorCode::LinkLost);
  rig.pass(4s);
  const auto state = rig.hand->state();
  INFO((state ? std::string() : state.error().text()));
  REQUIRE(state);
  CHECK(rig.plant.joint(0).strain_nm > 0.2);
  CHECK(rig.driver->report().loaded);
}

TEST_CASE("error frames and foreign traffic are counted and change nothing", "[hand][emulator]") {
  Rig rig(true);
  rig.start();
  const auto before = rig.driver->report().error_frames;
  rig.fault("0:noise:0.5");
  rig.fault("0:foreign:2");
  rig.grip();
  CHECK(rig.driver->report().error_frames - before == Approx(50).margin(2));
}

TEST_CASE("a link that is slow from the start is worked over and named", "[hand][emulator]") {
  Rig rig(true);
  rig.fault(GENERATE("0:late=20:60", "0:late=30:40"));
  rig.start();
  CHECK(rig.driver->report().remark.str().find("slow link") != std::string::npos);
  rig.grip();
}

TEST_CASE("a spread that is turned by more than its motor gives is a slip; by less it stays",
          "[hand][emulator]") {
  Rig rig(true);
  rig.start();
  rig.grip();
  rig.fault("0:turn=1500:0.5");
  rig.pass(600ms);
  CHECK_FALSE(rig.driver->report().slipped);
  rig.fault("0:turn=3000:0.5");
  rig.pass(600ms);
  CHECK(rig.driver->report().slipped);
  CHECK(rig.driver->report().why.str().find("the spread turned by") == 0);
  CHECK(rig.driver->report().loaded);
}

TEST_CASE("another program that sets a value is named, whether the bus shows it or not", "[hand][emulator]") {
  Rig rig(true);
  rig.start();
  rig.grip();
  rig.fault(GENERATE("0:master=900@F2", "0:altered=900@F2", "0:altered=3300@F2"));
  const auto e = rig.reported_fault(2s);
  CHECK(e.code == ErrorCode::DeviceFault);
  CHECK(e.detail.find("another program") != std::string::npos);
  CHECK(e.detail.find("F2") != std::string::npos);
}

TEST_CASE("what a client cannot know because of an injected fault is no broken rule", "[hand][emulator]") {
  Rig rig(true);
  rig.start();
  rig.grip();
  const char* fault = GENERATE("0:reset@F1", "0:brown-out", "0:off:1", "0:error=7@F3", "0:silent:1",
                               "0:bus-off:0.5", "0:jump=20000@F2");
  rig.fault(fault);
  rig.pass(3s);
  const auto& report = rig.pucks.report();
  for (std::size_t r = 0; r < sim_hal::kHandRules; ++r) {
    CAPTURE(fault, sim_hal::kHandRuleNames[r], report.first[r]);
    CHECK(report.broken[r] == 0);
  }
  // what it does wrong on its own account still counts
  hal::CanFrame save;
  save.id = 0x00b;
  save.length = 4;
  save.data = {0x80 | 30, 0, 0xff, 0xff};
  rig.bus.inject(save);
  rig.pass(10ms);
  CHECK(report.times(sim_hal::HandRule::Risky) == 1);
}

TEST_CASE("a finger cannot be turned from outside", "[hand][emulator]") {
  const auto refused = sim_hal::parse_hand_fault("0:turn=3000@F1");
  REQUIRE_FALSE(refused);
  CHECK(refused.error().detail.find("worm") != std::string::npos);
}

TEST_CASE("without a supply configure says that nobody is there", "[hand][emulator]") {
  Rig rig;
  rig.fault("0:off:10");
  rig.pass(5ms);
  const auto e = rig.hand->configure();
  REQUIRE_FALSE(e);
  CHECK(e.error().code == ErrorCode::LinkLost);
  CHECK(e.error().detail.find("supply") != std::string::npos);
}

TEST_CASE("a hand of 2010 is brought into the hand's group", "[hand][emulator]") {
  sim_hal::HandEmulatorConfig old;
  old.puck.group_c = 8;
  old.puck.firmware = 174;  // without IHIT
  Rig rig(true, {}, old);
  rig.start();
  for (std::size_t p = 0; p < 4; ++p) CHECK(rig.pucks.puck(p).listens_to(5));
  rig.grip();
}

TEST_CASE("same calls and seed, same frames", "[hand][emulator]") {
  const auto run = [] {
    Rig rig(true);
    std::vector<std::pair<hal::Timestamp, hal::CanFrame>> all;
    rig.bus.tap = [&](const hal::CanFrame& f) { all.emplace_back(rig.clock.now(), f); };
    rig.start();
    rig.grip();
    return all;
  };
  const auto one = run(), other = run();
  REQUIRE(one.size() == other.size());
  CHECK(one == other);
}
