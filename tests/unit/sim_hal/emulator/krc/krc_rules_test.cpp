#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <numbers>

#include "fri_peer.hpp"

using namespace colift;
using namespace colift::sim_hal;
using test::Bench;
using test::Seen;
using Bytes = std::vector<std::byte>;

namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

struct Offence {
  const char* what;
  std::function<void(Bytes&)> change;
  const char* rule;
  const char* told;
};

void add(Bytes& c, std::size_t offset, float by) {
  test::set<float>(c, offset, test::at<float>(c, offset) + by);
}

/// A session in which the offence is committed once command mode is there.
void commit(const Offence& offence, std::int32_t strategy, std::uint32_t flags) {
  CAPTURE(offence.what);
  Bench b;
  REQUIRE(b.krc->start(b.clock.now()));
  REQUIRE(b.command(strategy, flags));
  b.turns(10);
  REQUIRE(b.last.state() == 2);
  b.change = offence.change;
  b.turn();
  b.change = {};
  b.turn();
  CHECK(b.last.state() == 1);
  CHECK(b.broken() == offence.rule);
  CHECK(b.was_told(offence.told));
  REQUIRE(b.until([](const Seen& m) { return m.power() == 0; }));
  CHECK(b.krc->report().mode_changes.back().reason == b.krc->report().broken_rules.back().reason);
}

}  // namespace

TEST_CASE("in joint impedance each offence has its own name", "[krc]") {
  const std::vector<Offence> offences{
      {"flags", [](Bytes& c) { test::set<std::uint32_t>(c, 140, 0x0031); }, "flags-changed",
       "cmdFlags changed during cmd mode, from 0x0035 to 0x0031"},
      {"step", [](Bytes& c) { add(c, 144 + 8, 0.0121f); }, "step-too-large",
       "joint A3 asked for a step of 0.0121 rad (limit 0.0056 rad)"},
      {"speed of A1", [](Bytes& c) { add(c, 144, -0.0043f); }, "step-too-large", "joint A1"},
      {"position", [](Bytes& c) { test::set<float>(c, 144 + 4, 2.2f); }, "position-limit",
       "joint A2 asked for 2.2000 rad (limit 2.0944 rad)"},
      {"stiffness", [](Bytes& c) { test::set<float>(c, 272 + 24, 2001.0f); }, "gain-out-of-range",
       "joint A7"},
      {"negative stiffness", [](Bytes& c) { test::set<float>(c, 272, -1.0f); }, "gain-out-of-range", "A1"},
      {"damping", [](Bytes& c) { test::set<float>(c, 300, 1.01f); }, "gain-out-of-range", "damping ratio"},
      {"NaN", [](Bytes& c) { test::set<float>(c, 144, kNan); }, "not-finite", "jntPos"},
      {"infinite torque", [](Bytes& c) { test::set<float>(c, 220, std::numeric_limits<float>::infinity()); },
       "not-finite", "addJntTrq"},
      {"NaN gain", [](Bytes& c) { test::set<float>(c, 300 + 8, kNan); }, "not-finite", "jntDamping"},
      {"torque", [](Bytes& c) { test::set<float>(c, 220 + 24, 40.0f); }, "torque-limit", "joint A7"},
  };
  for (const Offence& o : offences) commit(o, 30, 0x35);
}

TEST_CASE("in position control and in Cartesian impedance, too", "[krc]") {
  commit({"flags", [](Bytes& c) { test::set<std::uint32_t>(c, 140, 0x0035); }, "flags-changed", "0x0001"}, 10,
         1);
  commit({"step", [](Bytes& c) { add(c, 144 + 24, 0.008f); }, "step-too-large", "joint A7"}, 10, 1);
  const std::vector<Offence> offences{
      {"frame step", [](Bytes& c) { add(c, 172 + 12, 0.005f); }, "frame-step-too-large", "0.0050 m"},
      {"no rotation", [](Bytes& c) { test::set<float>(c, 172, 3.0f); }, "not-finite", "rotation"},
      {"NaN", [](Bytes& c) { test::set<float>(c, 172 + 44, kNan); }, "not-finite", "cartPos"},
      {"stiffness", [](Bytes& c) { test::set<float>(c, 328, 5001.0f); }, "gain-out-of-range", "direction X"},
      {"turning stiffness about x", [](Bytes& c) { test::set<float>(c, 328 + 20, 301.0f); },
       "gain-out-of-range", "direction Rx"},
      {"damping", [](Bytes& c) { test::set<float>(c, 352, 10.0f); }, "gain-out-of-range",
       "damping ratio of 10"},
      {"force", [](Bytes& c) { test::set<float>(c, 248, 400.0f); }, "torque-limit", "400.0 N"},
      {"flags", [](Bytes& c) { test::set<std::uint32_t>(c, 140, 0x3501); }, "flags-changed", "0x3501"},
  };
  for (const Offence& o : offences) commit(o, 20, 0x3500);
}

TEST_CASE("who starts in the wrong way does not come into command mode, and is told why", "[krc]") {
  struct Entry {
    const char* rule;
    const char* told;
    std::int32_t strategy;
    std::uint32_t flags;
    std::function<void(Bytes&)> change;
  };
  const std::vector<Entry> entries{
      {"pose-mismatch", "FRI interpolation error: joint A4 starts 0.0100 rad off", 30, 0x35,
       [](Bytes& c) { add(c, 144 + 12, 0.01f); }},
      {"pose-mismatch", "joint A2", 10, 0x1, [](Bytes& c) { test::set<float>(c, 144 + 4, 0.0f); }},
      {"torque-not-initialised", "cmd.addJntTrq not properly initialized: joint A3 starts with 1.50 N m", 30,
       0x35, [](Bytes& c) { test::set<float>(c, 220 + 8, 1.5f); }},
      {"flags-do-not-fit", "flags 0x0035 do not fit position control", 10, 0x35, {}},
      {"flags-do-not-fit", "flags 0x3500 do not fit joint impedance", 30, 0x3500, {}},
      {"frame-mismatch", "cmd.cartPos not properly initialized: 0.0050 m", 20, 0x3500,
       [](Bytes& c) { add(c, 172 + 12, 0.005f); }},
      {"wrench-not-initialised", "cmd.addTcpFT not properly initialized", 20, 0x3500,
       [](Bytes& c) { test::set<float>(c, 248, 5.0f); }},
      {"gain-out-of-range", "damping ratio of 1.5", 30, 0x35,
       [](Bytes& c) { test::set<float>(c, 300, 1.5f); }},
      {"not-finite", "jntPos", 30, 0x35, [](Bytes& c) { test::set<float>(c, 144, kNan); }},
  };
  for (const Entry& e : entries) {
    CAPTURE(e.told);
    Bench b;
    REQUIRE(b.krc->start(b.clock.now()));
    b.change = e.change;
    CHECK_FALSE(b.command(e.strategy, e.flags));
    CHECK(b.broken() == e.rule);
    CHECK(b.was_told(std::string("friStart refused: ")));
    CHECK(b.was_told(e.told));
    // Stanford's program says "started" all the same, the drives stay on
    CHECK(b.last.to_int(15) == 20);
    CHECK(b.last.power() == 0x7F);
  }
}

TEST_CASE("fields without their flag may hold anything", "[krc]") {
  Bench b;
  REQUIRE(b.krc->start(b.clock.now()));
  b.change = [](Bytes& c) {
    for (std::size_t i = 172; i < 376; i += 4) test::set<float>(c, i, kNan);
  };
  REQUIRE(b.command(10, 0x1));
  b.turns(50);
  CHECK(b.last.state() == 2);
  CHECK(b.broken().empty());
}

TEST_CASE("a joint at its full speed is allowed, and the arm follows", "[krc]") {
  for (const std::int32_t strategy : {10, 30}) {
    LightPlantConfig plant = Bench::bent();
    plant.start_rad[4] = -2.0;
    Bench b(Bench::stanford(), plant);
    REQUIRE(b.krc->start(b.clock.now()));
    REQUIRE(b.command(strategy, strategy == 10 ? 0x1 : 0x35));
    hal::JointVector q = b.last.q_total();
    double speed = 0.0;
    const double most = 250.0 / 180.0 * std::numbers::pi * 0.002;
    for (int i = 0; i < 400; ++i) {
      speed = std::min(speed + 0.00005, most - 1e-6);
      q[4] += speed;
      b.q = q;
      b.turn();
      REQUIRE(b.last.state() == 2);
    }
    CHECK(b.last.q()[4] > 0.5);
    CHECK(std::abs(b.last.q()[4] - b.last.q_total()[4]) < 0.1);
  }
}

TEST_CASE("a client that sleeps for a moment may catch up no faster than its joints can", "[krc]") {
  Bench b;
  REQUIRE(b.krc->start(b.clock.now()));
  REQUIRE(b.command());
  hal::JointVector q = b.last.q_total();
  b.turns(5);
  b.say_nothing(3);
  q[0] += 4 * 0.0041;
  b.q = q;
  b.turns(2);
  CHECK(b.last.state() == 2);
  CHECK(b.broken().empty());
  b.say_nothing(2);
  q[0] += 4 * 0.0041;
  b.q = q;
  b.turns(2);
  CHECK(b.broken() == "step-too-large");
}

TEST_CASE("many single losses end command mode by quality", "[krc]") {
  Bench b;
  REQUIRE(b.krc->start(b.clock.now()));
  REQUIRE(b.command());
  bool left = false;
  for (int i = 0; i < 300 && !left; ++i) {
    if (i % 3 == 0)
      b.say_nothing(1);
    else
      b.turn();
    left = b.last.state() == 1;
  }
  CHECK(left);
  CHECK(b.broken() == "quality-lost");
  CHECK(b.was_told("quality fell to unacceptable"));
}

TEST_CASE("a strict controller wants perfect quality and keeps to it", "[krc]") {
  KrcConfig config = Bench::stanford();
  config.strict = true;
  Bench b(config);
  REQUIRE(b.krc->start(b.clock.now()));
  REQUIRE(b.command());
  for (int i = 0; i < 100 && b.last.state() == 2; ++i) {
    if (i % 5 == 0)
      b.say_nothing(1);
    else
      b.turn();
  }
  CHECK(b.last.state() == 1);
  CHECK(b.was_told("quality fell to bad"));
}

TEST_CASE("garbage and strangers are refused and counted", "[krc]") {
  Bench b;
  REQUIRE(b.krc->start(b.clock.now()));
  REQUIRE(b.command());
  b.turns(3);
  const std::vector<std::byte> good = b.answer(b.last);
  b.wire.inject({0x0A000001, 49938}, Bench::kKrc, good);
  b.wire.inject({0x7F000001, 50123}, Bench::kKrc, good);  // another port than the client's
  b.turns(3);
  CHECK(b.broken().empty());
  CHECK(b.krc->report().rejected.size() == 2);
  b.wire.inject(Bench::kClient, Bench::kKrc, std::vector<std::byte>(375));
  b.wire.inject(Bench::kClient, Bench::kKrc, std::vector<std::byte>(1400));
  auto wrong = good;
  test::set<std::uint16_t>(wrong, 6, 0x1004);
  b.wire.inject(Bench::kClient, Bench::kKrc, wrong);
  b.turns(3);
  CHECK(b.broken() == "bad-datagram bad-datagram bad-datagram");
  bool told = false;
  for (const auto& [why, count] : b.krc->report().rejected)
    told = told || why.find("1400 bytes") != std::string::npos;
  CHECK(told);
  CHECK(b.last.state() == 2);  // nothing of it reached the arm
}

TEST_CASE("an old command never moves the arm", "[krc]") {
  Bench b;
  REQUIRE(b.krc->start(b.clock.now()));
  REQUIRE(b.command());
  b.turns(3);
  auto old = b.answer(b.last);
  add(old, 144, 0.003f);
  b.turns(3);
  const hal::JointVector total = b.last.q_total();
  b.reply(old);
  b.reply(old);
  b.turns(3);
  CHECK((b.last.q_total() - total).norm() < 1e-9);
  CHECK(b.krc->report().reordered == 2);
  CHECK(b.last.state() == 2);
}

TEST_CASE("a client whose counter jumps back in command mode loses command mode", "[krc]") {
  Bench b;
  REQUIRE(b.krc->start(b.clock.now()));
  REQUIRE(b.command());
  b.turns(50);
  REQUIRE(b.last.state() == 2);
  b.send = static_cast<std::uint16_t>(b.send - 1000);
  b.turns(400);
  CHECK(b.last.state() == 1);
  CHECK(b.krc->report().reordered > 2);
}

TEST_CASE("a client that begins anew in monitor mode counts from its own beginning", "[krc]") {
  Bench b;
  b.send = 40000;
  REQUIRE(b.krc->start(b.clock.now()));
  b.turns(150);
  b.send = 0;
  b.turns(10);
  CHECK(b.last.reflected() == 9);
  CHECK(b.last.quality() == 3);
}
