#include <catch2/catch.hpp>
#include <cmath>

#include "planner/grasp/grasp_stability.hpp"

using namespace colift;
using hal::Vec3;
using planner::GraspCandidate;
using planner::HandModel;

namespace {

GraspCandidate pinch(const Vec3& approach, const Vec3& closing, double width = 0.02) {
  GraspCandidate c;
  c.approach = approach;
  c.closing = closing;
  c.width = width;
  return c;
}

double margin(const GraspCandidate& c, const Vec3& force, const Vec3& torque = Vec3::Zero()) {
  return planner::stability_margin(c, HandModel{}, {force, torque});
}

}  // namespace

TEST_CASE("a load along the pads is held by friction: two sides, two fingers of 15 N each, mu one half",
          "[stability]") {
  const auto from_above = pinch(-Vec3::UnitZ(), Vec3::UnitY());
  CHECK(margin(from_above, {0, 0, -30}) == Approx(1.0));
  CHECK(margin(from_above, {0, 0, -60}) == Approx(0.5));
  CHECK(margin(from_above, {30, 0, 0}) == Approx(1.0));
}

TEST_CASE("a load on two locked fingers is borne up to twice one finger's limit", "[stability]") {
  const auto sideways = pinch(Vec3::UnitX(), Vec3::UnitZ());  // the single finger is above
  CHECK(margin(sideways, {0, 0, -39.2}) == Approx(1.0));
  const auto turned = pinch(Vec3::UnitX(), -Vec3::UnitZ());  // the single finger is below
  CHECK(margin(turned, {0, 0, -39.2}) == Approx(0.5));
}

TEST_CASE("a torque about the closing axis turns the object in the pads", "[stability]") {
  const auto c = pinch(-Vec3::UnitZ(), Vec3::UnitY());
  const HandModel hand;
  const double r = 2.0 / 3.0 * std::sqrt(0.02 * 0.02 / 3.14159265358979);
  const double twist = 0.5 * 30.0 * (std::sqrt(0.025 * 0.025 + r * r) + r);
  CHECK(planner::grasp_strength(c, hand).twist_nm == Approx(twist));
  CHECK(margin(c, Vec3::Zero(), {0, twist, 0}) == Approx(1.0));
  // load and torque together leave less than either
  CHECK(margin(c, {0, 0, -15}, {0, 0.5 * twist, 0}) == Approx(1.0 / std::sqrt(0.5)));
}

TEST_CASE("no load is held for ever, and more friction holds more", "[stability]") {
  const auto c = pinch(-Vec3::UnitZ(), Vec3::UnitY());
  CHECK(std::isinf(margin(c, Vec3::Zero())));
  HandModel rough;
  rough.friction = 1.0;
  CHECK(planner::stability_margin(c, rough, {{0, 0, -10}, Vec3::Zero()}) > margin(c, {0, 0, -10}));
}

TEST_CASE("fingers behind a pipe's middle hook it, before it they let it go", "[stability]") {
  const HandModel hand;
  auto thin = pinch(-Vec3::UnitZ(), Vec3::UnitY(), 0.06);
  thin.kind = planner::GraspKind::Wrap;
  auto thick = pinch(-Vec3::UnitZ(), Vec3::UnitY(), 0.185);
  thick.kind = planner::GraspKind::Wrap;
  const double flat = planner::grasp_strength(pinch(-Vec3::UnitZ(), Vec3::UnitY(), 0.06), hand).pull_n;
  CHECK(planner::grasp_strength(thin, hand).pull_n > flat);
  CHECK(planner::grasp_strength(thick, hand).pull_n < flat);
  // what hangs in the hook is borne, however smooth it is
  HandModel smooth;
  smooth.friction = 0.05;
  const hal::Wrench pull{{0, 0, -20}, Vec3::Zero()};
  CHECK(planner::stability_margins(thin, smooth, pull).slip > 10.0);
  CHECK(planner::stability_margins(thick, smooth, pull).slip < 0.1);
  // held from farther away, the same pipe is only pinched
  thin.gap_m = hand.largest_gap(thin);
  CHECK(planner::grasp_strength(thin, hand).pull_n < flat * 1.001);
}

TEST_CASE("fingers that bear a load rub more", "[stability]") {
  const HandModel hand;
  const auto plate = pinch(Vec3::UnitX(), Vec3::UnitZ());  // two fingers below
  // half of the weight, pushed along the rim: above twice the squeeze nothing slides however heavy it is
  const auto slip = [&](double down, double along) {
    return planner::stability_margins(plate, hand, {{0, along, -down}, Vec3::Zero()}).slip;
  };
  CHECK(slip(0.0, 20.0) == Approx(30.0 / 20.0));
  // both sides press with 2 x 30 N + a third of what they bear together
  CHECK(slip(30.0, 20.0) == Approx(30.0 / (20.0 - 0.5 * 10.0)));
  CHECK(std::isinf(slip(60.0, 20.0)));
}

TEST_CASE("a torque about the approach presses fingers, it does not slide them", "[stability]") {
  const HandModel hand;
  const auto plate = pinch(Vec3::UnitX(), Vec3::UnitZ());
  const auto m = planner::stability_margins(plate, hand, {{0, 0, -10}, {0.5, 0, 0}});
  CHECK(std::isinf(m.slip));
  CHECK(m.bear == Approx(hand.finger_hold_n / (5.0 + 0.5 / 0.045)));
  CHECK(m.least() == m.bear);
}

TEST_CASE("a pipe's own axis takes no torque from where the pads are", "[stability]") {
  const HandModel hand;
  auto pipe = pinch(Vec3::UnitX(), Vec3::UnitZ(), 0.07);
  pipe.kind = planner::GraspKind::Wrap;
  pipe.depth_m = 0.07;
  // the same load, named at the axis 35 mm behind the surface and at the pads 70 mm behind it
  const Vec3 force(0, 0, -30), off = 0.035 * pipe.approach;
  const auto at_pads = planner::stability_margins(pipe, hand, {force, -off.cross(force)});
  pipe.depth_m = 0.035;
  const auto at_axis = planner::stability_margins(pipe, hand, {force, Vec3::Zero()});
  CHECK(at_pads.slip == Approx(at_axis.slip));
}

TEST_CASE("the couple that the decision leaves to the partner comes to the robot, his force does not",
          "[stability]") {
  planner::AgentWrenches w;
  w.partner = {{0, 0, 20}, {0.1, 0, 0}};
  w.robot = {{0, 0, 30}, {0.2, 0, 0}};
  const auto load = planner::load_on_robot(w);
  CHECK(load.force.isApprox(Vec3(0, 0, -30)));
  CHECK(load.torque.isApprox(Vec3(-0.3, 0, 0)));
  CHECK(planner::fingertip_force(HandModel{}, 0.57) == Approx(10.0));
}

TEST_CASE("the nominal load hangs at a lever about the line to the centre of gravity", "[stability]") {
  GraspCandidate c;
  c.position = {0.4, 0, 0.5};
  const planner::StabilityConfig config;
  const auto load = planner::nominal_load(c, Vec3::UnitZ(), {0, 0, 0.3}, config);
  CHECK(load.force.isApprox(Vec3(0, 0, -config.load_n)));
  CHECK(load.torque.isApprox(Vec3(-config.load_n * config.cog_lever_m, 0, 0)));
  c.position = {0, 0, 0.5};  // right above it there is no line, and no lever
  CHECK(planner::nominal_load(c, Vec3::UnitZ(), {0, 0, 0.3}, config).torque.norm() == 0.0);
}
