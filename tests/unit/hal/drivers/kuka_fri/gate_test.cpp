#include <catch2/catch.hpp>

#include "hal/drivers/kuka_fri/wire/packet_gate.hpp"

namespace colift::hal {
namespace {

struct Gate {
  PacketGate gate;
  FriMeasurement m;
  Timestamp now{std::chrono::seconds(1)};
  const Endpoint krc{0xC0A80014, 49152};

  explicit Gate(const Endpoint& allowed = {}, bool sequence = true) : gate(allowed, {}, sequence) {
    m.state = FriState::Monitor;
  }
  PacketGate::Passed look(int send, const Endpoint& from) {
    now += std::chrono::milliseconds(2);
    FriMeasurement sent = m;
    sent.head.send = static_cast<std::uint16_t>(send);
    std::array<std::byte, kFriMeasurementBytes> bytes{};
    encode(sent, bytes);
    FriMeasurement out;
    return gate.look({Datagram::Kind::Data, bytes.size(), from, now}, bytes, 0.002, out);
  }
  PacketGate::Passed look(int send) { return look(send, krc); }
};

}  // namespace

TEST_CASE("the first good sender is locked in", "[fri][gate]") {
  Gate g;
  CHECK(g.look(1).drop == FriDrop::None);
  CHECK(g.look(2, {0xC0A80015, 49152}).drop == FriDrop::Sender);
  CHECK(g.look(2, {0xC0A80014, 49153}).drop == FriDrop::Sender);
  CHECK(g.look(2).drop == FriDrop::None);
  // after a lost link it may come back from another port, but not from another machine
  g.gate.unlock();
  CHECK(g.look(1, {0xC0A80015, 49152}).drop == FriDrop::Sender);
  CHECK(g.look(1, {0xC0A80014, 49153}).drop == FriDrop::None);
  CHECK(g.look(2).drop == FriDrop::Sender);
}

TEST_CASE("a sender that was configured is the only one", "[fri][gate]") {
  Gate any_port({0xC0A80014, 0});
  CHECK(any_port.look(1, {0xC0A80099, 49152}).drop == FriDrop::Sender);
  CHECK(any_port.look(1, {0xC0A80014, 7}).drop == FriDrop::None);
  Gate one_port({0xC0A80014, 7010});
  CHECK(one_port.look(1).drop == FriDrop::Sender);
  CHECK(one_port.look(1, {0xC0A80014, 7010}).drop == FriDrop::None);
}

TEST_CASE("a second sender is one that could be the KRC", "[fri][gate]") {
  Gate g({0xC0A80014, 0});
  CHECK(g.look(1).drop == FriDrop::None);
  CHECK(g.look(1, {0xC0A80099, 49152}).drop == FriDrop::Sender);  // never allowed
  CHECK_FALSE(g.gate.rival());
  CHECK(g.look(7, {0xC0A80014, 7}).drop == FriDrop::Sender);
  CHECK(g.look(8, {0xC0A80014, 7}).drop == FriDrop::Sender);
  REQUIRE(g.gate.rival());
  CHECK(g.gate.rival()->who == Endpoint{0xC0A80014, 7});
  CHECK(g.gate.rival()->datagrams == 2);
  // a KRC that was restarted sends from another port: it is itself
  g.gate.unlock();
  CHECK(g.look(9, {0xC0A80014, 7}).drop == FriDrop::None);
  CHECK_FALSE(g.gate.rival());
}

TEST_CASE("counters are compared as signed 16-bit differences", "[fri][gate]") {
  Gate g;
  CHECK(g.look(65534).cycles == 1);
  CHECK(g.look(65535).cycles == 1);
  CHECK(g.look(0).cycles == 1);
  CHECK(g.look(4).cycles == 4);
  CHECK(g.look(4).drop == FriDrop::Doubled);
  CHECK(g.look(65535).drop == FriDrop::Old);
  CHECK(g.look(3).drop == FriDrop::Old);
  CHECK(g.look(5).drop == FriDrop::None);
}

TEST_CASE("a new count is believed when the old one has ended, not before", "[fri][gate]") {
  Gate g;
  for (int i = 1; i <= 500; ++i) REQUIRE(g.look(2000 + i).drop == FriDrop::None);
  SECTION("an old burst between new datagrams is not a new count") {
    for (int i = 0; i < 40; ++i) CHECK(g.look(1000 + i).drop == FriDrop::Old);
    CHECK(g.look(2545).drop == FriDrop::None);
  }
  SECTION("a restart is") {
    int until = 0;
    while (until < 200 && g.look(++until).drop != FriDrop::None) {
    }
    CHECK(until >= 40);
    CHECK(until <= 60);
    CHECK(g.look(until + 1).cycles == 1);
  }
  SECTION("a counter far ahead of the time is not") {
    CHECK(g.look(10000).drop == FriDrop::Ahead);
  }
}

TEST_CASE("without counters everything of the right sender passes", "[fri][gate]") {
  Gate g({}, false);
  for (int i = 0; i < 10; ++i) CHECK(g.look(0).drop == FriDrop::None);
}

}  // namespace colift::hal
