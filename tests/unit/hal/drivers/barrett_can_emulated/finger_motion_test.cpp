// One finger alone, on emulated pucks: to an angle, by a step, with a velocity, with a torque; and what is
// refused.
#include "hal/drivers/barrett_can/service/finger_motion.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "hal/types/units.hpp"
#include "tests/contract/barrett_rig.hpp"

using namespace colift;
using Kind = hal::FingerMotion::Kind;
using hal::barrett::Puck;
using namespace std::chrono_literals;

namespace {

struct Bench : BarrettRig {
  explicit Bench(bool with_object = false) : BarrettRig(with_object) {
    REQUIRE(hand->configure());
    REQUIRE(hand->activate());
    hand->deactivate();
  }
  hal::Result<hal::FingerMotionEnd> move(Kind kind, double value,
                                         const std::function<void(hal::FingerMotion&)>& more = {},
                                         Puck finger = Puck::F2) {
    hal::FingerMotion motion;
    motion.kind = kind;
    motion.finger = finger;
    motion.value = value;
    if (more) more(motion);
    return hal::move_finger(*client, clock, {}, motion);
  }
  hal::FingerMotionEnd moved(Kind kind, double value,
                             const std::function<void(hal::FingerMotion&)>& more = {}) {
    const auto end = move(kind, value, more);
    INFO((end ? std::string() : end.error().text()));
    REQUIRE(end);
    INFO(end->how);
    CHECK(end->rests);
    CHECK(pucks.puck(1).value(8) == 0);  // MODE
    for (std::size_t r = 0; r < sim_hal::kHandRules; ++r) {
      INFO(pucks.report().first[r]);
      CHECK(pucks.report().broken[r] == 0);
    }
    return *end;
  }
  double rad(std::size_t finger) { return plant.joint(finger).motor / 81487.33; }
};

}  // namespace

TEST_CASE("one finger goes to an angle and by a step, and the others stay", "[hand][service]") {
  Bench b;
  const auto to = b.moved(Kind::To, 1.0);
  CHECK(to.as_asked);
  CHECK(to.to_rad == Approx(1.0).margin(0.01));
  const auto step = b.moved(Kind::Step, -0.25);
  CHECK(step.as_asked);
  CHECK(step.from_rad == Approx(1.0).margin(0.01));
  CHECK(step.to_rad == Approx(0.75).margin(0.01));
  CHECK(b.rad(0) < 0.01);
  CHECK(b.rad(2) < 0.01);
  CHECK(b.plant.joint(3).motor < 100.0);
}

TEST_CASE("a velocity is kept for its time, and ends at the end of the range", "[hand][service]") {
  Bench b;
  const auto some = b.moved(Kind::Velocity, 0.4, [](hal::FingerMotion& m) { m.for_s = 1.0; });
  CHECK(some.as_asked);
  CHECK(some.took_s == Approx(1.0).margin(0.1));
  CHECK(some.to_rad == Approx(0.4).margin(0.06));
  const auto back = b.moved(Kind::Velocity, -0.5, [](hal::FingerMotion& m) { m.for_s = 5.0; });
  CHECK(back.how.find("end of its range") != std::string::npos);
  CHECK(back.to_rad < 0.06);
}

TEST_CASE("a torque closes a finger onto an object, no harder than asked", "[hand][service]") {
  Bench b(true);
  const auto end = b.moved(Kind::Torque, 0.4, [](hal::FingerMotion& m) { m.for_s = 4.0; });
  CHECK(end.to_rad > 0.5);
  CHECK(end.to_rad < 2.0);
  CHECK(end.max_torque_nm > 0.1);
  CHECK(end.max_torque_nm < 0.6);
}

TEST_CASE("a finger that meets something before its angle says so", "[hand][service]") {
  Bench b(true);
  const auto end = b.moved(Kind::To, 2.2);
  CHECK_FALSE(end.as_asked);
  CHECK(end.how.find("met") != std::string::npos);
  CHECK(end.to_rad < 2.0);
}

TEST_CASE("an interrupted finger stays where it is with its motor off", "[hand][service]") {
  Bench b;
  const auto until = b.clock.now() + 700ms;
  hal::FingerMotion motion;
  motion.value = 2.0;
  motion.finger = Puck::F1;
  const auto end = hal::move_finger(*b.client, b.clock, {}, motion, [&] { return b.clock.now() > until; });
  REQUIRE(end);
  CHECK_FALSE(end->as_asked);
  CHECK(end->rests);
  CHECK(end->to_rad < 1.9);
}

TEST_CASE("what a single finger must not do is refused before anything moves", "[hand][service]") {
  Bench b;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto code = [&](Kind kind, double value, const std::function<void(hal::FingerMotion&)>& more = {},
                        Puck finger = Puck::F2) {
    const auto end = b.move(kind, value, more, finger);
    REQUIRE_FALSE(end);
    return end.error().code;
  };
  CHECK(code(Kind::To, 2.5) == hal::ErrorCode::LimitExceeded);
  CHECK(code(Kind::To, -0.1) == hal::ErrorCode::LimitExceeded);
  CHECK(code(Kind::To, nan) == hal::ErrorCode::LimitExceeded);
  CHECK(code(Kind::Step, 3.0) == hal::ErrorCode::LimitExceeded);
  CHECK(code(Kind::Velocity, 1.0) == hal::ErrorCode::LimitExceeded);
  CHECK(code(Kind::Velocity, nan) == hal::ErrorCode::LimitExceeded);
  CHECK(code(Kind::Velocity, -0.3) == hal::ErrorCode::LimitExceeded);  // it is open already
  CHECK(code(Kind::Torque, 5.0) == hal::ErrorCode::LimitExceeded);
  CHECK(code(Kind::Torque, 0.0) == hal::ErrorCode::LimitExceeded);
  CHECK(code(Kind::To, 1.0, {}, Puck::Spread) == hal::ErrorCode::LimitExceeded);
  CHECK(code(Kind::Torque, 0.3, [](hal::FingerMotion& m) { m.for_s = 1e9; }) ==
        hal::ErrorCode::LimitExceeded);
  CHECK(b.rad(1) < 0.01);

  BarrettRig asleep(false);
  REQUIRE(asleep.client->open());
  const auto cold = hal::move_finger(*asleep.client, asleep.clock, {}, {});
  REQUIRE_FALSE(cold);
  CHECK(cold.error().code == hal::ErrorCode::NotReady);
}

TEST_CASE("one finger moves at 64 C and is refused at 65 C", "[hand][service]") {
  const int celsius = GENERATE(64, 65);
  Bench b;
  const auto hot = sim_hal::parse_hand_fault("0:hot=" + std::to_string(celsius) + "@F2:60");
  REQUIRE(hot);
  sim_hal::HandFault fault = *hot;
  fault.at_s += hal::seconds(b.clock.now());
  b.pucks.inject(fault);
  b.pass(50ms);
  const auto end = b.move(Kind::To, 1.0);
  CAPTURE(celsius);
  REQUIRE(end.has_value() == (celsius < 65));
  if (end) return;  // how far its faded motor comes is another matter
  CHECK(end.error().code == hal::ErrorCode::DeviceFault);
  CHECK(end.error().detail.find("F2 has 65 C (limit 65)") == 0);
  CHECK(b.rad(1) < 0.01);
  CHECK(b.move(Kind::To, 1.0, {}, Puck::F3));  // the others are cool
}

TEST_CASE("a finger opens from a grip that is stronger than its own limit of torque", "[hand][service]") {
  Bench b(true);
  REQUIRE(b.hand->activate());
  REQUIRE(b.hand->close(1.0));
  b.pass(2500ms);
  REQUIRE(b.hand->state()->held);
  REQUIRE(b.hand->state()->torque_nm[2] > 0.6);  // F3 presses against the two others
  b.hand->deactivate();
  const auto opened = b.move(
      Kind::To, 0.0, [](hal::FingerMotion& m) { m.although_closed = true; }, Puck::F3);
  REQUIRE(opened);
  INFO(opened->how);
  CHECK(opened->as_asked);
  CHECK(opened->rests);
  CHECK(b.rad(2) < 0.01);
}

TEST_CASE("a closed finger that opens is stopped by what loads it behind its relief", "[hand][service]") {
  Bench b;
  (void)b.moved(Kind::To, 2.0);
  const auto weight = sim_hal::parse_hand_fault("0.45:weight=0.8@F2:5");
  REQUIRE(weight);
  sim_hal::HandFault fault = *weight;
  fault.at_s += hal::seconds(b.clock.now());
  b.pucks.inject(fault);
  const auto end = b.moved(Kind::To, 0.0, [](hal::FingerMotion& m) { m.although_closed = true; });
  CHECK_FALSE(end.as_asked);
  CHECK(end.how.find("enough") != std::string::npos);
  CHECK(end.to_rad > 0.3);
  CHECK(end.to_rad < 1.65);
}

TEST_CASE("a finger of a hand that may hold something opens with a word of consent only", "[hand][service]") {
  Bench b(true);
  REQUIRE(b.hand->activate());
  REQUIRE(b.hand->close(0.6));
  b.pass(2500ms);
  CHECK(b.hand->state()->held);
  b.hand->deactivate();
  const auto refused = b.move(Kind::Step, -0.2);
  REQUIRE_FALSE(refused);
  CHECK(refused.error().code == hal::ErrorCode::NotReady);
  CHECK(refused.error().detail.find("--yes") != std::string::npos);
  const auto opened = b.moved(Kind::Step, -0.2, [](hal::FingerMotion& m) { m.although_closed = true; });
  CHECK(opened.as_asked);
}
