#include <catch2/catch.hpp>

#include "lift_rig.hpp"

// Truth: Newton's laws for the object (weight, lever rule) against what contacts and partner report.

namespace colift::sim_hal {
namespace {

constexpr double kG = 9.81, kDegree = 3.14159265358979 / 180.0;

void grasp_table(LiftRig& rig) {
  rig.move(around_edge(), 0.8);
  REQUIRE(rig.close());
  REQUIRE(rig.world().hand_state().held);
}

TEST_CASE("the hand closes around a table's edge, lifts it with the partner, and both share the load") {
  LiftRig rig(table_scenario(), before_edge());
  grasp_table(rig);
  const double weight = 4.0 * kG;
  rig.move(around_edge() + Vec3(0, 0, 0.05), 2.0, 0.5 * weight);
  rig.wait(1.0);
  const SimTruth up = rig.mean(1.0);
  CHECK(up.floor_force_W.norm() == 0.0);
  CHECK(up.height_m == Approx(0.05).margin(0.004));
  CHECK(up.tilt_rad < 0.5 * kDegree);
  CHECK(up.slip_m < 0.001);
  CHECK((up.robot_force_W + up.partner_force_W).z() == Approx(weight).margin(0.5));
  // the palm's contacts are 1 to 3 cm inside of the edge, so the robot has a little more than half
  CHECK(up.robot_force_W.z() / weight == Approx(0.53).margin(0.03));
  CHECK_FALSE(up.robot_hit_something);

  rig.move(around_edge(), 2.0, 0.5 * weight);
  rig.move(around_edge(), 0.5, 0.0);
  CHECK(rig.mean(0.5).floor_force_W.z() == Approx(weight).margin(2.5));
  rig.world().open_hand();
  rig.wait(1.2);
  CHECK_FALSE(rig.world().hand_state().held);
  CHECK_FALSE(rig.world().truth().robot_touches_object);
  CHECK(rig.world().truth().tilt_rad < 0.1 * kDegree);
  CHECK(rig.world().truth().divergences == 0);
}

TEST_CASE("what the arm feels outside of itself is the transposed Jacobian times the load in its hand") {
  LiftRig rig(table_scenario(), before_edge());
  grasp_table(rig);
  rig.move(around_edge() + Vec3(0, 0, 0.05), 2.0, 20.0);
  rig.wait(0.5);
  hal::JointVector measured = hal::JointVector::Zero(), expected = hal::JointVector::Zero();
  for (int i = 0; i < 200; ++i) {  // over whole periods of the tremor, near enough
    rig.wait(0.005);
    const SimTruth truth = rig.world().truth();
    Eigen::Matrix<double, 6, 1> on_hand;
    on_hand << -truth.robot_force_W, -truth.robot_torque_W;
    expected += hal::jacobian(hal::built_in_robot(), truth.q_rad, Vec3::Zero()).transpose() * on_hand / 200;
    measured += rig.world().arm_state().tau_external_nm / 200;
  }
  INFO(measured.transpose() << " against " << expected.transpose());
  CHECK(expected.cwiseAbs().maxCoeff() > 10.0);
  CHECK((measured - expected).cwiseAbs().maxCoeff() < 0.05);
}

TEST_CASE("with less force ahead the arm sags, as its stiffness says") {
  double height[2];
  for (const bool ahead : {false, true}) {
    LiftRig rig(table_scenario(), before_edge());
    grasp_table(rig);
    rig.move(around_edge() + Vec3(0, 0, 0.05), 2.0, ahead ? 20.0 : 0.0);
    rig.wait(1.0);
    height[ahead] = rig.world().truth().height_m;
  }
  CHECK(height[1] - height[0] > 0.005);
  CHECK(height[0] > 0.02);
}

Scenario upright_box(double friction) {
  Scenario s;
  s.object.kind = "box";
  s.object.size = {0.5, 0.06, 0.3};
  s.object.mass = 3.0;
  s.object.friction = friction;
  s.object.xyz = {0.80, 0.0, 0.0};
  s.partner.grasp = {0.25, 0.0, 0.2};
  s.partner.arrives_s = 0.2;
  return s;
}

SimTruth lift_box_from_above(double friction, double torque_nm) {
  const Vec3 above(0.62, 0.0, 0.45), around(0.62, 0.0, 0.345);
  LiftRig rig(upright_box(friction), hand_at(above, -Vec3::UnitZ(), Vec3::UnitY()));
  rig.move(around, 0.8);
  REQUIRE(rig.close(torque_nm));
  rig.move(around + Vec3(0, 0, 0.05), 2.0, 12.0);
  rig.wait(1.0);
  return rig.world().truth();
}

TEST_CASE("a box between the fingers is held by friction, or slips when there is too little of it") {
  const SimTruth rough = lift_box_from_above(0.7, 0.75);
  CHECK(rough.floor_force_W.norm() == 0.0);
  CHECK(rough.height_m > 0.035);
  CHECK(rough.slip_m < 0.003);
  const SimTruth smooth = lift_box_from_above(0.05, 0.75);
  CHECK(smooth.slip_m > 0.01);
  CHECK(smooth.robot_force_W.z() < 8.0);
}

TEST_CASE("when the partner lets go his share comes onto the robot or the floor") {
  Scenario s = table_scenario();
  s.partner.events = {{7.5, "let-go", std::nullopt}};
  LiftRig rig(s, before_edge());
  grasp_table(rig);
  rig.move(around_edge() + Vec3(0, 0, 0.05), 2.0, 20.0);
  while (hal::seconds(rig.world().clock().now()) < 6.4) rig.wait(0.005);
  const SimTruth with = rig.mean(1.0);
  CHECK(with.partner_W.has_value());
  rig.wait(3.0);
  const SimTruth without = rig.mean(0.5);
  CHECK_FALSE(without.partner_W.has_value());
  CHECK(without.partner_force_W.norm() == 0.0);
  CHECK((without.robot_force_W + without.floor_force_W).z() == Approx(4.0 * kG).margin(0.5));
  CHECK(without.tilt_rad > 1.0 * kDegree);
}

TEST_CASE("a short object that its partner lets go hangs on the robot alone") {
  Scenario s = upright_box(0.9);
  s.object.size = {0.3, 0.06, 0.3};
  s.object.mass = 1.0;
  s.object.xyz = {0.70, 0.0, 0.0};
  s.partner.grasp = {0.15, 0.0, 0.2};
  s.partner.events = {{7.0, "let-go", std::nullopt}};
  const Vec3 above(0.65, 0.0, 0.45), around(0.65, 0.0, 0.345);
  LiftRig rig(s, hand_at(above, -Vec3::UnitZ(), Vec3::UnitY()));
  rig.move(around, 0.8);
  REQUIRE(rig.close());
  rig.move(around + Vec3(0, 0, 0.1), 2.0, 6.0);
  while (hal::seconds(rig.world().clock().now()) < 6.2) rig.wait(0.005);
  const SimTruth before = rig.mean(0.5);
  CHECK((before.robot_force_W + before.partner_force_W).z() == Approx(kG).margin(0.3));
  rig.wait(1.5);
  const SimTruth after = rig.mean(0.5);
  CHECK(after.floor_force_W.norm() == 0.0);
  CHECK(after.robot_force_W.z() == Approx(kG).margin(0.3));
  CHECK(after.slip_m < 0.02);
}

TEST_CASE("on a fixed block the robot alone lifts its side and the object tilts about the block") {
  Scenario s = table_scenario();
  s.partner.kind = "support";
  LiftRig rig(s, before_edge());
  grasp_table(rig);
  CHECK(rig.mean(0.3).partner_force_W.z() < 15.0);
  rig.move(around_edge() + Vec3(0, 0, 0.05), 2.0, 20.0);
  rig.wait(0.5);
  const SimTruth up = rig.mean(0.5);
  CHECK(up.floor_force_W.norm() == 0.0);
  CHECK((up.robot_force_W + up.partner_force_W).z() == Approx(4.0 * kG).margin(0.5));
  // 5 cm over the 0.75 m from the fingers to the block's far edge
  CHECK(up.tilt_rad / kDegree == Approx(3.6).margin(0.4));
}

TEST_CASE("a leading partner lifts first and the robot that follows levels the object") {
  Scenario s = table_scenario();
  s.partner.kind = "leader";
  s.task.hold_s = 4.0;
  LiftRig rig(s, before_edge());
  grasp_table(rig);
  rig.wait(3.2);
  const SimTruth led = rig.world().truth();
  CHECK(led.tilt_rad > 2.5 * kDegree);
  CHECK(led.partner_W->z() > 0.4375 + 0.04);
  rig.move(around_edge() + Vec3(0, 0, 0.05), 1.5, 20.0);
  rig.wait(0.5);
  CHECK(rig.world().truth().tilt_rad < 0.7 * kDegree);
  CHECK(rig.world().truth().floor_force_W.norm() == 0.0);
}

}  // namespace
}  // namespace colift::sim_hal
