// Zeros that look known: believed only from this life of the pucks, and where both encoders agree.
#include "hand_rig.hpp"

using namespace colift;
using namespace std::chrono_literals;
using Catch::Matchers::Contains;
using hal::ErrorCode;

namespace {

struct Initialised {
  HandRig rig;
  Initialised() {
    for (FakePuck& puck : rig.fake.pucks) puck.powered_at = rig.clock.now();
    rig.fake.pass(7s);
    rig.start();
    rig.hand.deactivate();
  }
  hal::Result<> next_start(const char* initialise = "when-needed") {
    hal::BarrettHandConfig config;
    config.initialise = initialise;
    hal::BarrettHand next(*rig.fake.host, config, rig.clock);
    return next.configure();
  }
};

}  // namespace

TEST_CASE("a zero of this life is believed by the next program", "[hand][zero]") {
  Initialised h;
  h.rig.fake.pass(300s);
  const std::size_t from = h.rig.fake.from_host.size();
  REQUIRE(h.next_start("never"));
  for (std::size_t p = 0; p < 4; ++p) CHECK(h.rig.fake.sets(p, 29, from) == 0);
}

TEST_CASE("a zero that was saved to flash is not believed after the puck was switched off", "[hand][zero]") {
  Initialised h;
  h.rig.fake.pass(60s);
  // somebody saved all properties; then the hand was off, with a bent finger, and another program woke it
  FakePuck& f1 = h.rig.fake.pucks[0];
  const std::int32_t mark = f1.property[56], note = f1.property[60];
  f1.position = 60'000;
  f1.reset();
  f1.powered_at = h.rig.clock.now();
  f1.stat = 2;
  f1.property[56] = mark;
  f1.property[60] = note;
  h.rig.fake.pass(30s);
  const auto refused = h.next_start();
  REQUIRE_FALSE(refused);
  CHECK(refused.error().code == ErrorCode::NotReady);
  CHECK_THAT(refused.error().detail, Contains("F1") && Contains("earlier life") && Contains("hal hand init"));
  CHECK(f1.position == 60'000);  // nothing moved on a suspicion
  // a person has freed it
  REQUIRE(h.next_start("always"));
  CHECK(f1.position < 500);
  REQUIRE(h.next_start("never"));
}

TEST_CASE("a motor that is behind its joint's encoder has no zero", "[hand][zero]") {
  Initialised h;
  // the light fake has one shift for both encoders: the joint's is spoiled on its way
  h.rig.fake.bus.fate = [&](const hal::CanFrame& f, const sim_hal::MemoryCan::Node*) {
    if (f.id == 0x583) const_cast<hal::CanFrame&>(f).data[3] |= 0x01;  // 65 536 counts
    return sim_hal::MemoryCan::Fate{1, 150us};
  };
  const auto refused = h.next_start();
  REQUIRE_FALSE(refused);
  CHECK(refused.error().code == ErrorCode::NotReady);
  CHECK_THAT(refused.error().detail, Contains("F2 contradict"));
}

TEST_CASE("the clock of a puck begins anew after nine hours, and its zero stays known", "[hand][zero]") {
  Initialised h;
  h.rig.clock.advance(std::chrono::seconds(32'768 + 100));
  REQUIRE(h.next_start("never"));
}
