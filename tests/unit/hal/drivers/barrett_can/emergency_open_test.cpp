// A hand that holds something and does not work any more: whoever stands there wants it open, not diagnosed.
#include "hal/drivers/barrett_can/emergency_open.hpp"

#include "hand_rig.hpp"

namespace colift {

using namespace std::chrono_literals;

namespace {

/// Grips with one process, and opens with another one that knows nothing.
struct Gripped : HandRig {
  Gripped() {
    start();
    grip();
  }
  [[nodiscard]] hal::Result<std::array<hal::FingerOpening, 3>> open() {
    return hal::emergency_open(*fake.host, clock, config);
  }
  [[nodiscard]] bool is_open(std::size_t finger) const { return fake.pucks[finger].position < 1000.0; }
};

}  // namespace

TEST_CASE("a new process opens a hand that another one left gripping", "[hand][faults]") {
  Gripped rig;
  const double spread = rig.fake.pucks[3].position;
  const auto fingers = rig.open();
  REQUIRE(fingers);
  for (std::size_t i = 0; i < 3; ++i) {
    CHECK(rig.is_open(i));
    CHECK(rig.fake.pucks[i].mode() == 0);
    CHECK((*fingers)[i].rests);
  }
  CHECK(rig.fake.pucks[3].position == spread);
  CHECK(hal::describe(*fingers).find("F1 opened by 69 degrees; its motor rests") == 0);
}

TEST_CASE("one finger that is silent keeps no other from opening", "[hand][faults]") {
  Gripped rig;
  rig.fake.pucks[1].silent = true;
  const auto fingers = rig.open();
  REQUIRE(fingers);
  CHECK(rig.is_open(0));
  CHECK_FALSE(rig.is_open(1));
  CHECK(rig.is_open(2));
  CHECK_FALSE((*fingers)[1].answers);
  CHECK(hal::describe(*fingers).find("F2 does not answer and was not opened") != std::string::npos);
}

TEST_CASE("a finger that was reset while it was closed is woken, and opens though it has no zero",
          "[hand][faults]") {
  Gripped rig;
  rig.fake.pucks[0].reset();
  REQUIRE(rig.fake.pucks[0].stat == 0);
  const auto fingers = rig.open();
  REQUIRE(fingers);
  for (std::size_t i = 0; i < 3; ++i) CHECK(rig.is_open(i));
}

TEST_CASE("a finger that is stuck ends in a resting motor", "[hand][faults]") {
  Gripped rig;
  rig.fake.pucks[2].stuck = rig.fake.pucks[2].never_ends = true;
  const hal::Timestamp began = rig.clock.now();
  const auto fingers = rig.open();
  REQUIRE(fingers);
  CHECK((*fingers)[2].from - (*fingers)[2].to < 1000);
  CHECK(rig.fake.pucks[2].mode() == 0);
  CHECK(rig.clock.now() - began < 10s);
}

TEST_CASE("whoever interrupts it leaves resting motors", "[hand][faults]") {
  Gripped rig;
  int asked = 0;
  const auto fingers =
      hal::emergency_open(*rig.fake.host, rig.clock, rig.config, [&] { return ++asked > 300; });
  REQUIRE(fingers);
  rig.fake.pass(50ms);
  for (std::size_t i = 0; i < 3; ++i) CHECK(rig.fake.pucks[i].mode() == 0);
}

TEST_CASE("nobody on the bus is said", "[hand][faults]") {
  Gripped rig;
  for (auto& puck : rig.fake.pucks) puck.silent = true;
  const auto fingers = rig.open();
  REQUIRE_FALSE(fingers);
  CHECK(fingers.error().code == hal::ErrorCode::LinkLost);
}

}  // namespace colift
