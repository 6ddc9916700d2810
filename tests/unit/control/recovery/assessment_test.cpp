#include "control/recovery/assessment.hpp"

#include <catch2/catch.hpp>
#include <limits>

using namespace colift;
using namespace colift::control;

namespace {

const hal::JointVector kHome = (hal::JointVector() << 0.0, 0.35, 0.0, 1.75, 0.0, -0.9, 0.0).finished();

std::vector<hal::ArmState> at(const hal::JointVector& q_rad, double down_n) {
  hal::ArmState s;
  s.q_rad = q_rad;
  Eigen::Matrix<double, 6, 1> wrench = Eigen::Matrix<double, 6, 1>::Zero();
  wrench[2] = -down_n;
  s.tau_external_nm = hal::jacobian(hal::built_in_robot(), q_rad, hal::Vec3::Zero()).transpose() * wrench;
  return {s, s, s};
}

Assessment of(const std::vector<hal::ArmState>& arm, const std::optional<hal::HandState>& hand) {
  return assess(arm, hand, kHome, hal::built_in_robot(), planner::HandModel{}, {});
}

hal::HandState fingers(double rad) {
  hal::HandState hand;
  hand.finger_rad.fill(rad);
  return hand;
}

}  // namespace

TEST_CASE("a hand is taken as empty only when every finger is open", "[recovery]") {
  CHECK_FALSE(of(at(kHome, 0), fingers(0.02)).may_hold());
  CHECK(of(at(kHome, 0), fingers(1.2)).hand == Assessment::Hand::Between);
  CHECK(of(at(kHome, 0), fingers(1.2)).may_hold());
  CHECK(of(at(kHome, 0), fingers(2.44)).hand == Assessment::Hand::Closed);
  CHECK(of(at(kHome, 0), fingers(2.44)).may_hold());  // around something thin, for all that is known
  hal::HandState one = fingers(0.0);
  one.finger_rad[2] = 0.8;
  CHECK(of(at(kHome, 0), one).may_hold());
  hal::HandState held = fingers(0.05);
  held.held = true;
  CHECK(of(at(kHome, 0), held).hand == Assessment::Hand::Holds);
}

TEST_CASE("what is not measured is unknown", "[recovery]") {
  const Assessment silent = of({}, std::nullopt);
  CHECK(silent.arm == Assessment::Arm::Unknown);
  CHECK(silent.hand == Assessment::Hand::Unknown);
  CHECK(silent.may_hold());
  CHECK_FALSE(silent.load_n);
  CHECK_THAT(silent.load_words, Catch::Contains("unknown"));
  auto broken = at(kHome, 10.0);
  broken.back().q_rad[3] = std::numeric_limits<double>::quiet_NaN();
  CHECK(of(broken, fingers(0)).arm == Assessment::Arm::Unknown);
}

TEST_CASE("position and load are told with figures", "[recovery]") {
  CHECK(of(at(kHome, 0), fingers(0)).arm == Assessment::Arm::AtHome);
  hal::JointVector there = kHome;
  there[0] += 0.5;
  const Assessment away = of(at(there, 23.0), fingers(1.0));
  CHECK(away.arm == Assessment::Arm::Away);
  CHECK_THAT(away.arm_words, Catch::Contains("A1 by 29 deg"));
  REQUIRE(away.load_n);
  CHECK(*away.load_n == Approx(23.0).margin(0.1));
  auto moving = at(kHome, 0);
  moving.front().q_rad[1] -= 0.02;
  CHECK(of(moving, fingers(0)).arm == Assessment::Arm::Moving);
}
