// A warm puck gives less torque than it is told, and says nothing about it.
#include "hand_rig.hpp"

namespace colift {

namespace {

constexpr int kTemp = 9;

void heat(HandRig& rig, int celsius) {
  for (std::size_t i = 0; i < 3; ++i) rig.fake.pucks[i].property[kTemp] = celsius;
  rig.pass(std::chrono::milliseconds(1500));
}

}  // namespace

TEST_CASE("a grip with a tenth of its force is no grip", "[hand][faults]") {
  HandRig rig;
  rig.start();
  heat(rig, 58);
  rig.put_object(1.2);
  REQUIRE(rig.hand.close(0.8));
  CHECK_FALSE(rig.settle().held);
  CAPTURE(rig.why());
  CHECK(rig.why().find("holds with") != std::string::npos);
  CHECK(rig.why().find("at 58 C its puck gives 12 % of its torque") != std::string::npos);
}

TEST_CASE("a hand of an ordinary temperature grips", "[hand][faults]") {
  HandRig rig;
  rig.start();
  heat(rig, GENERATE(30, 44, 50));
  rig.grip();
}

TEST_CASE("the force that fades is told before it is gone", "[hand][faults]") {
  HandRig rig;
  rig.start();
  heat(rig, 43);
  CHECK(rig.hand.report().warning.empty());
  heat(rig, 48);
  CHECK(rig.hand.report().warning.str().find("its pucks give 75 % of their torque") != std::string::npos);
}

}  // namespace colift
