// Another program on the same bus: it is named, and nothing moves on against it.
#include "hal/drivers/barrett_can/pucks/puck_codec.hpp"
#include "hand_rig.hpp"

using namespace colift;
using namespace std::chrono_literals;
using Catch::Matchers::Contains;
using hal::ErrorCode;

namespace {

hal::CanFrame frame(int id, std::initializer_list<int> bytes) {
  hal::CanFrame f;
  f.id = static_cast<std::uint16_t>(id);
  for (const int b : bytes) f.data[f.length++] = static_cast<std::uint8_t>(b);
  return f;
}

std::string fault(HandRig& rig) {
  const auto state = rig.hand.state();
  return state || state.error().code != ErrorCode::DeviceFault ? std::string() : state.error().detail;
}

}  // namespace

TEST_CASE("a setting by somebody else is named at once, and the motion stops", "[hand][master]") {
  HandRig rig;
  rig.start();
  REQUIRE(rig.hand.close(0.5));
  rig.pass(300ms);
  const int id = GENERATE(0x00c, 0x0cc, 0x12c, 0x405);  // from 0, 6 and 9 to F2; from 0 to the whole hand
  rig.fake.bus.inject(frame(id, {0x80 | 43, 0, 0x84, 0x03}));
  CHECK(until(rig, 50ms, [&] { return !fault(rig).empty(); }) <= 5ms);
  CHECK_THAT(fault(rig), Contains("another program") && Contains("MT") && Contains("900"));
  CHECK_THAT(fault(rig), Contains(id == 0x405 ? "all pucks" : "F2"));
  rig.pass(50ms);
  const double at = rig.fake.pucks[0].position;
  rig.pass(500ms);
  CHECK(rig.fake.pucks[0].position == at);
  CHECK(rig.hand.close(0.5).error().code == ErrorCode::DeviceFault);
  // a person has looked
  REQUIRE(rig.hand.configure());
  REQUIRE(rig.hand.activate());
  CHECK(rig.hand.state());
}

TEST_CASE("a loaded hand keeps its grip against another program, and may be released", "[hand][master]") {
  HandRig rig;
  rig.start();
  rig.grip();
  const double at = rig.fake.pucks[1].position;
  rig.fake.bus.inject(frame(0x00c, {0x80 | 43, 0, 0x84, 0x03}));
  rig.pass(2s);
  CHECK_THAT(fault(rig), Contains("another program"));
  CHECK(rig.fake.pucks[1].position == Approx(at).margin(100));
  CHECK(rig.hand.report().loaded);
  REQUIRE(rig.hand.release());
  rig.pass(2s);
  CHECK(rig.fake.pucks[1].position < 1000);
}

TEST_CASE("who only asks harms nobody: a warning, and it passes", "[hand][master]") {
  HandRig rig;
  rig.start();
  rig.grip();
  rig.fake.bus.inject(frame(0x00b, {48}));
  rig.pass(20ms);
  CHECK_THAT(rig.look().warning.str(), Contains("another program asks"));
  CHECK(rig.look().held);
  rig.pass(2500ms);
  CHECK(rig.look().warning.empty());
}

TEST_CASE("a working value that somebody changed unseen is named within a second", "[hand][master]") {
  HandRig rig;
  rig.start();
  rig.grip();
  const int property = GENERATE(52, 43, 78, 45, 77);  // E, MT, TSTOP, MV, HOLD
  rig.pass(500ms);
  REQUIRE(fault(rig).empty());
  rig.fake.pucks[1].property[static_cast<std::size_t>(property)] += 700;
  CAPTURE(property);
  CHECK(until(rig, 2s, [&] { return !fault(rig).empty(); }) <= 1s);
  CHECK_THAT(fault(rig), Contains("another program commands the hand") && Contains("of F2"));
}

TEST_CASE("a long quiet life names nobody", "[hand][master]") {
  HandRig rig;
  rig.start();
  for (int i = 0; i < 3; ++i) {
    rig.grip();
    rig.pass(2s);
    REQUIRE(rig.hand.release());
    (void)rig.settle();
    REQUIRE(rig.hand.preshape(0.3 * i));
    (void)rig.settle();
    rig.pass(1s);
    CHECK(fault(rig).empty());
  }
}

TEST_CASE("requests of hosts are told from answers and from other traffic", "[hand][master]") {
  using hal::barrett::decode_request;
  CHECK(decode_request(frame(0x00b, {48})));
  CHECK(decode_request(frame(0x0cb, {0x88, 0, 0, 0}))->from == 6);
  CHECK(decode_request(frame(0x00b, {0x80 | 52, 0, 0x18, 0xfc, 0xff, 0xff}))->value == -1000);
  CHECK_FALSE(decode_request(frame(0x563, {0x80, 0, 0})));     // a puck
  CHECK_FALSE(decode_request(frame(0x540, {0x85, 0, 0, 0})));  // a WAM's safety module
  CHECK_FALSE(decode_request(frame(0x001, {5})));              // to a WAM's first puck
  CHECK_FALSE(decode_request(frame(0x401, {0xaa, 0, 0, 0, 0, 0, 0, 0})));
  CHECK_FALSE(decode_request(frame(0x00b, {})));
  // and pass the filters of the bus
  const auto passes = [](int id) {
    for (const auto& f : hal::barrett::hand_filters())
      if ((id & f.mask) == f.id) return true;
    return false;
  };
  for (const int id : {0x00b, 0x405, 0x0cc, 0x4c5, 0x12d, 0x563, 0x586}) CHECK(passes(id));
  for (const int id : {0x540, 0x021, 0x423}) CHECK_FALSE(passes(id));
}
