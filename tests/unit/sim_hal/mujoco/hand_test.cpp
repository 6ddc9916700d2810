#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "lift_rig.hpp"
#include "sim_hal/mujoco/devices/sim_devices.hpp"
#include "sim_hal/mujoco/hand_drive.hpp"

namespace colift::sim_hal {
namespace {

using hal::ErrorCode;

constexpr double kClosed_rad = 140.0 * std::numbers::pi / 180.0;

LiftRig free_hand(std::vector<DeviceFaultEvent> faults = {}) {
  Scenario s = table_scenario();
  s.partner.kind = "none";
  s.faults = std::move(faults);
  return LiftRig(s, hand_at({0.45, 0.0, 0.6}, Vec3::UnitX(), Vec3::UnitZ()));
}

TEST_CASE("a hand that closes on nothing ends fully closed and holds nothing") {
  LiftRig rig = free_hand();
  double fastest = 0.0;
  rig.world().close_hand(0.75);
  double last = 0.0;
  int ms = 0;
  for (; rig.world().hand_state().moving; ms += 5) {
    REQUIRE(ms < 4000);
    rig.wait(0.005);
    const double now = rig.world().hand_state().finger_rad[2];
    fastest = std::max(fastest, (now - last) / 0.005);
    last = now;
  }
  const hal::HandState state = rig.world().hand_state();
  CHECK_FALSE(state.held);
  for (std::size_t f = 0; f < hal::kFingers; ++f) {
    CHECK(state.finger_rad[f] == Approx(kClosed_rad).margin(0.01));
    CHECK(state.outer_rad[f] == Approx(kClosed_rad / 3.0).margin(0.01));
    CHECK(state.tip_force_n[f] == 0.0);
  }
  CHECK(fastest < 2.45);
  CHECK(ms > 1900);
  CHECK(ms < 2600);
}

TEST_CASE("the outer link turns a third of the inner one while it is free") {
  LiftRig rig = free_hand();
  rig.world().close_hand(0.75);
  for (int i = 0; i < 150; ++i) {
    rig.wait(0.005);
    const hal::HandState s = rig.world().hand_state();
    for (std::size_t f = 0; f < hal::kFingers; ++f)
      CHECK(s.outer_rad[f] == Approx(s.finger_rad[f] / 3.0).margin(0.01));
  }
}

TEST_CASE("the spread turns once the fingers are open") {
  LiftRig rig = free_hand();
  rig.world().preshape_hand(1.0);
  rig.wait(1.5);
  const hal::HandState s = rig.world().hand_state();
  CHECK_FALSE(s.moving);
  CHECK(s.spread_rad == Approx(1.0).margin(0.01));
  rig.world().preshape_hand(0.0);
  rig.wait(1.0);
  CHECK(rig.world().hand_state().spread_rad == Approx(0.0).margin(0.01));
}

TEST_CASE("the strain gauges stay below the closing torque and show the tips' load") {
  LiftRig rig(table_scenario(), before_edge());
  rig.move(around_edge(), 0.8);
  REQUIRE(rig.close(0.6));
  const hal::HandState s = rig.world().hand_state();
  CHECK(s.held);
  CHECK_FALSE(s.moving);
  for (std::size_t f = 0; f < hal::kFingers; ++f) {
    CHECK(s.torque_nm[f] > 0.2);
    CHECK(s.torque_nm[f] < 0.8);
    CHECK(s.tip_force_n[f] > 8.0);
  }
  // two fingers stand against one
  CHECK(s.tip_force_n[0] + s.tip_force_n[1] == Approx(s.tip_force_n[2]).epsilon(0.15));
  const hal::HandState later = (rig.wait(5.0), rig.world().hand_state());
  for (std::size_t f = 0; f < hal::kFingers; ++f)
    CHECK(later.finger_rad[f] == Approx(s.finger_rad[f]).margin(0.005));
}

// a plank of 12 x 3 cm on two stands, taken flat from above: only the inner links meet its sides
TEST_CASE("when the inner links are blocked the outer ones go on") {
  Scenario s;
  s.object.kind = "box";
  s.object.size = {0.12, 0.8, 0.03};
  s.object.mass = 2.0;
  s.object.xyz = {0.65, 0.0, 0.2};
  s.partner.kind = "none";
  s.clutter = {{"box", {0.1, 0.05, 0.2}, {0.65, 0.35, 0.0}, 0.0},
               {"box", {0.1, 0.05, 0.2}, {0.65, -0.35, 0.0}, 0.0}};
  const Vec3 above(0.65, 0.0, 0.4), around(0.65, 0.0, 0.255);
  LiftRig rig(s, hand_at(above, -Vec3::UnitZ(), Vec3::UnitX()));
  rig.move(around, 0.8);
  REQUIRE(rig.close(0.75));
  const hal::HandState hand = rig.world().hand_state();
  CHECK(hand.held);
  for (std::size_t f = 0; f < hal::kFingers; ++f) {
    INFO("finger " << f << ": " << hand.finger_rad[f] << ", " << hand.outer_rad[f]);
    CHECK(hand.outer_rad[f] > hand.finger_rad[f] / 3.0 + 0.1);
  }
  rig.move(around + Vec3(0, 0, 0.06), 1.5, 18.0);
  rig.wait(0.5);
  CHECK(rig.world().truth().floor_force_W.norm() == 0.0);
  CHECK(rig.world().truth().height_m > 0.04);
  rig.move(around, 1.5, 0.0);
  rig.world().open_hand();
  rig.wait(1.5);
  for (std::size_t f = 0; f < hal::kFingers; ++f) {
    CHECK(rig.world().hand_state().finger_rad[f] == Approx(0.0).margin(0.01));
    CHECK(rig.world().hand_state().outer_rad[f] == Approx(0.0).margin(0.01));
  }
}

TEST_CASE("a loaded hand opens on release alone, and its device says so") {
  LiftRig rig(table_scenario(), before_edge());
  const auto hand = make_sim_hand(rig.world());
  CHECK(hand->close(0.5).error().code == ErrorCode::NotReady);
  REQUIRE(hand->configure());
  REQUIRE(hand->activate());
  CHECK(hand->close(-1.0).error().code == ErrorCode::LimitExceeded);
  CHECK(hand->close(std::nan("")).error().code == ErrorCode::LimitExceeded);
  CHECK(hand->preshape(4.0).error().code == ErrorCode::LimitExceeded);
  rig.move(around_edge(), 0.8);
  REQUIRE(hand->close(0.75));
  CHECK(hand->state()->moving);
  rig.wait(2.5);
  REQUIRE(hand->state()->held);
  CHECK(hand->preshape(0.0).error().code == ErrorCode::NotReady);
  hand->stop();
  hand->deactivate();
  rig.wait(0.2);
  REQUIRE(hand->activate());
  CHECK(hand->state()->held);
  CHECK(rig.world().truth().robot_touches_object);
  REQUIRE(hand->release());
  rig.wait(1.5);
  CHECK_FALSE(hand->state()->held);
  CHECK(hand->preshape(0.0));
}

TEST_CASE("a scenario's faults of the hand show as the interface says") {
  LiftRig rig = free_hand({{0.1, "hand", "silent", 0.1},
                           {0.3, "hand", "freeze", 0.1},
                           {0.5, "hand", "corrupt", 0.1},
                           {0.7, "hand", "unplug", 0.1}});
  const auto hand = make_sim_hand(rig.world());
  REQUIRE(hand->configure());
  REQUIRE(hand->activate());
  CHECK(hand->state());
  rig.wait(0.15);
  CHECK(hand->state().error().code == ErrorCode::Timeout);
  CHECK(hand->close(0.5).error().code == ErrorCode::Timeout);
  rig.wait(0.1);
  CHECK(hand->state()->measured_at == rig.world().clock().now());
  rig.wait(0.1);
  CHECK(hand->state()->measured_at < rig.world().clock().now());
  rig.wait(0.2);
  CHECK(std::isnan(hand->state()->finger_rad[1]));
  rig.wait(0.2);
  CHECK(hand->state().error().code == ErrorCode::LinkLost);
  CHECK(hand->configure().error().code == ErrorCode::LinkLost);
  rig.wait(0.2);
  CHECK(hand->state().error().code == ErrorCode::LinkLost);
  CHECK(hand->configure());
  CHECK(hand->state());
}

// Three fingers with a spring before each, at an angle that gives way.
struct Spring {
  static constexpr double kGear_nm_rad = 300.0, kStiffness_nm_rad = 40.0, kTipOfInner = 0.4;
  double at_rad = 1.0;
  HandReading reading{};

  void pass(HandDrive& drive, int ms) {
    for (int i = 0; i < ms; ++i) {
      const HandTorque gears = drive.tick(reading);
      for (std::size_t f = 0; f < hal::kFingers; ++f) {
        const double worm_rad = reading.inner_rad[f] + gears.inner_nm[f] / kGear_nm_rad;
        const double link_rad = worm_rad < at_rad ? worm_rad
                                                  : (kGear_nm_rad * worm_rad + kStiffness_nm_rad * at_rad) /
                                                        (kGear_nm_rad + kStiffness_nm_rad);
        const double force_nm = std::max(0.0, kStiffness_nm_rad * (link_rad - at_rad));
        reading.inner_rad[f] = link_rad;
        reading.outer_rad[f] = link_rad / 3.0;
        reading.strain_nm[f] = kTipOfInner * force_nm;
        reading.link_force_n[f] = 20.0 * force_nm;
      }
    }
  }
  [[nodiscard]] double weakest_nm() const {
    return *std::min_element(reading.strain_nm.begin(), reading.strain_nm.end());
  }
};

TEST_CASE("a grip that gives way is pressed again, by motors that have power") {
  HandDrive drive;
  Spring object;
  drive.close(1.0);
  object.pass(drive, 2500);
  REQUIRE(drive.held());
  REQUIRE_FALSE(drive.moving());
  REQUIRE(object.weakest_nm() > 0.7);

  object.at_rad += 0.05;
  object.pass(drive, 500);
  CHECK(drive.held());
  CHECK_FALSE(drive.moving());
  CHECK(object.weakest_nm() > 0.25);
  CHECK(object.weakest_nm() < 0.4);

  drive.stop();  // a grip is kept
  object.at_rad += 0.05;
  object.pass(drive, 500);
  CHECK(object.weakest_nm() > 0.25);

  drive.power(false);
  object.at_rad += 0.05;
  object.pass(drive, 500);
  CHECK(drive.held());
  CHECK(object.weakest_nm() < 0.05);
  drive.power(true);
  object.pass(drive, 500);
  CHECK(object.weakest_nm() > 0.25);

  object.at_rad = 10.0;
  object.pass(drive, 3000);
  CHECK_FALSE(drive.held());
}

TEST_CASE("a hand without a grip does not press when it gets power") {
  HandDrive drive;
  Spring nothing{.at_rad = 10.0};
  drive.power(true);
  nothing.pass(drive, 500);
  CHECK(nothing.reading.inner_rad[0] == 0.0);
}

}  // namespace
}  // namespace colift::sim_hal
