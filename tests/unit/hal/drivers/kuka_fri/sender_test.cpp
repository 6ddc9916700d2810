// Who is the KRC? With fri.krc empty the first sender is read, and moved by nobody who is not sure of it.
#include "fri_arm_rig.hpp"

namespace colift {

using namespace test;

namespace {

/// A second sender on the driver's port, which speaks before the controller does and looks like one.
struct Rival {
  FakeKrc& krc;
  Endpoint from;
  FriMeasurement m;
  bool speaks = true;

  Rival(FakeKrc& k, const Endpoint& e) : krc(k), from(e) {
    m = krc.m;
    m.state = hal::FriState::Command;
    m.q_measured_rad = m.q_commanded_rad = {0.5f, 0.5f, 0.5f, 0.5f, 0.5f, 0.5f, 0.5f};
    krc.tamper = [this](FriMeasurement&) {
      if (!speaks) return true;
      ++m.head.send;
      m.head.size = hal::kFriMeasurementBytes;
      m.head.id = hal::kFriMeasurementId;
      std::vector<std::byte> bytes(hal::kFriMeasurementBytes);
      hal::encode(m, std::span<std::byte, hal::kFriMeasurementBytes>(bytes));
      krc.wire.inject(from, krc.pc, bytes);
      return krc_speaks;
    };
  }
  ~Rival() { krc.tamper = nullptr; }
  bool krc_speaks = true;
};

constexpr Endpoint kStranger{0xC0A80063, 5555}, kNeighbour{0x7F000001, 40000};

}  // namespace

TEST_CASE("another machine is read without its name, and not asked for command mode", "[fri][faults]") {
  FakeKrc krc;
  Rival only(krc, {0xC0A80014, 49152});
  only.krc_speaks = false;
  only.m.state = GENERATE(hal::FriState::Monitor, hal::FriState::Command);
  const auto arm = krc.arm();
  REQUIRE(arm->configure());
  CHECK(next(*arm).q_rad[0] == Approx(0.5));
  const auto refused = arm->activate();
  REQUIRE_FALSE(refused);
  CHECK(refused.error().code == ErrorCode::NotReady);
  CHECK(refused.error().detail.find("192.168.0.20:49152, another machine") != std::string::npos);
  CHECK(refused.error().detail.find("krc: 192.168.0.20 in the file") != std::string::npos);
  CHECK_FALSE(next(*arm).may_command);
  CHECK(arm->status().reason == hal::FriReason::KrcNotNamed);
}

TEST_CASE("the same machine, named, is", "[fri][faults]") {
  FakeKrc krc;
  Rival only(krc, {0xC0A80014, 49152});
  only.krc_speaks = false;
  hal::FriConfig config = FakeKrc::quick();
  config.krc = GENERATE("192.168.0.20", "192.168.0.20:49152");
  const auto arm = krc.arm(config);
  REQUIRE(arm->configure());
  const auto active = arm->activate();
  INFO((active ? "" : active.error().text()));
  CHECK(active);
}

TEST_CASE("two senders, the hostile one first: no command mode, and both are named", "[fri][faults]") {
  FakeKrc krc;
  const Endpoint who = GENERATE(kStranger, kNeighbour);
  Rival rival(krc, who);
  hal::FriConfig config = FakeKrc::quick();
  config.script = "colift";  // whoever is asked sees it in FRM_INT[2]
  rival.m.krl.integer[0] = 10001;
  rival.m.krl.integer[1] = 1;
  auto ear = krc.wire.end(who);
  REQUIRE(ear->open());
  const auto arm = krc.arm(config);
  REQUIRE(arm->configure());
  next(*arm);
  REQUIRE(arm->status().krc == who);
  const auto refused = arm->activate();
  REQUIRE_FALSE(refused);
  CHECK(arm->status().reason == hal::FriReason::SecondSender);
  CHECK(refused.error().detail.find("two senders") != std::string::npos);
  CHECK(refused.error().detail.find("127.0.0.1:49152") != std::string::npos);
  CHECK(refused.error().detail.find(who == kStranger ? "192.168.0.99:5555" : "127.0.0.1:40000") !=
        std::string::npos);
  for (int i = 0; i < 100; ++i) CHECK_FALSE(next(*arm).may_command);
  CHECK(krc.m.state == hal::FriState::Monitor);
  CHECK(krc.torque_outside == 0);
  int answers = 0;
  std::array<std::byte, 512> bytes{};
  for (auto got = ear->receive(bytes, hal::Duration::zero()); got.kind == hal::Datagram::Kind::Data;
       got = ear->receive(bytes, hal::Duration::zero())) {
    hal::FriCommand c;
    REQUIRE(hal::decode(std::span(bytes).first(got.size), c) == hal::FriRefusal::None);
    CHECK(c.krl.integer[1] == 0);
    ++answers;
  }
  CHECK(answers > 100);
}

TEST_CASE("a sender that is named is taken, whoever comes first", "[fri][faults]") {
  FakeKrc krc;
  Rival rival(krc, GENERATE(kStranger, kNeighbour));
  hal::FriConfig config = FakeKrc::quick();
  config.krc = "127.0.0.1:49152";
  const auto arm = krc.arm(config);
  REQUIRE(arm->configure());
  REQUIRE(arm->activate());
  CHECK(arm->status().krc == krc.own);
  const JointVector q = next(*arm).q_rad;
  CHECK(arm->command(hold_at(q)));
  CHECK(arm->status().drops[static_cast<std::size_t>(hal::FriDrop::Sender)] > 10);
}

TEST_CASE("a second sender that begins while command mode is waited for ends the wait", "[fri][faults]") {
  FakeKrc krc;
  krc.start_when_good = false;
  const auto arm = krc.arm();
  REQUIRE(arm->configure());
  Rival rival(krc, kNeighbour);
  rival.speaks = false;
  int cycles = 0;
  krc.after = [&](const std::vector<std::byte>&) { rival.speaks = ++cycles > 100; };
  const auto refused = arm->activate();
  REQUIRE_FALSE(refused);
  CHECK(arm->status().reason == hal::FriReason::SecondSender);
  krc.after = nullptr;
}

TEST_CASE("once the second sender is gone for a second, the KRC is certain again", "[fri][faults]") {
  FakeKrc krc;
  const auto arm = krc.arm();
  REQUIRE(arm->configure());
  {
    Rival rival(krc, kNeighbour);
    for (int i = 0; i < 20; ++i) next(*arm);
    CHECK_FALSE(arm->activate());
  }
  for (int i = 0; i < 600; ++i) next(*arm);
  CHECK(arm->status().doubt == hal::FriReason::None);
  CHECK(arm->activate());
}

}  // namespace colift
