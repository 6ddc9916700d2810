#include <catch2/catch.hpp>

#include "sim_hal/mujoco/sim_partner.hpp"

// The object is led by the test: what the partner does is judged by his force alone.

namespace colift::sim_hal {
namespace {

ScenarioPartner at_origin(const std::string& kind) {
  ScenarioPartner p;
  p.kind = kind;
  p.grasp = {0.4, 0.0, 0.4};
  p.arrives_s = 1.0;
  return p;
}

PartnerView view_at(double t_s, double rise_m = 0.0) {
  PartnerView view;
  view.t_s = t_s;
  view.X_WT.translation().z() = rise_m;
  view.robot_T = Vec3(-0.4, 0.0, 0.4);
  return view;
}

TEST_CASE("a partner pulls at nothing before he arrives and after he has let go") {
  ScenarioPartner script = at_origin("compliant");
  script.events = {{2.0, "let-go", std::nullopt}};
  SimPartner partner(script, {}, 1);
  CHECK_FALSE(partner.tick(view_at(0.999)));
  CHECK(partner.tick(view_at(1.0)));
  CHECK(partner.tick(view_at(1.999)));
  CHECK_FALSE(partner.tick(view_at(2.0)));
  CHECK_FALSE(partner.tick(view_at(9.0)));
}

TEST_CASE("a partner who moves holds the new place one second later") {
  ScenarioPartner script = at_origin("compliant");
  script.events = {{2.0, "move", Vec3(0.4, 0.2, 0.4)}};
  SimPartner partner(script, {}, 1);
  CHECK(partner.tick(view_at(1.5))->at_W.isApprox(Vec3(0.4, 0.0, 0.4)));
  CHECK_FALSE(partner.tick(view_at(2.5)));
  CHECK(partner.tick(view_at(3.0))->at_W.isApprox(Vec3(0.4, 0.2, 0.4)));
  CHECK(partner.hold_to_show(2.1)->grasp_T.y() == 0.0);
  CHECK(partner.hold_to_show(2.6)->grasp_T.y() == 0.2);
}

TEST_CASE("an event that counts from a state waits for it") {
  ScenarioPartner script = at_origin("compliant");
  script.events = {{0.5, "let-go", std::nullopt, "lift"}};
  SimPartner partner(script, {}, 1);
  CHECK(partner.tick(view_at(5.0)));
  partner.task_state("close", 5.0);
  partner.task_state("lift", 6.0);
  CHECK(partner.tick(view_at(6.49)));
  CHECK_FALSE(partner.tick(view_at(6.5)));
}

TEST_CASE("who stumbles pulls at the object for a moment") {
  ScenarioPartner script = at_origin("compliant");
  PartnerScriptEvent stumble{2.0, "stumble", std::nullopt};
  stumble.force_n = 90.0;
  stumble.for_s = 0.3;
  script.events = {stumble};
  SimPartner partner(script, {}, 1);
  CHECK(partner.tick(view_at(1.9))->force_W.norm() < 15.0);
  CHECK(partner.tick(view_at(2.1))->force_W.x() == Approx(90.0).margin(15.0));
  CHECK(partner.tick(view_at(2.31))->force_W.norm() < 15.0);
}

TEST_CASE("who sways takes his hand aside and back again") {
  ScenarioPartner script = at_origin("compliant");
  PartnerScriptEvent sway{2.0, "sway", std::nullopt};
  sway.for_s = 2.0;
  sway.by_m = 0.02;
  sway.direction = hal::Vec3(0.0, -1.0, 0.0);
  script.events = {sway};
  SimPartner partner(script, {}, 1);
  const auto force_n = [&](double t_s) { return partner.tick(view_at(t_s))->force_W; };
  CHECK(std::abs(force_n(1.9).y()) < 3.0);
  CHECK(force_n(3.0).y() == Approx(-30.0).margin(3.0));  // 1500 N/m, farthest in the middle
  CHECK(std::abs(force_n(3.0).x()) < 3.0);
  CHECK(std::abs(force_n(4.01).y()) < 3.0);
}

TEST_CASE("a second hand holds too, until he lets go, and who steps aside goes") {
  ScenarioPartner script = at_origin("compliant");
  script.events = {{2.0, "second-hand", Vec3(0.4, 0.2, 0.4)}, {3.0, "steps-aside", std::nullopt}};
  SimPartner partner(script, {}, 1);
  const double one_n = partner.tick(view_at(1.5, -0.002))->force_W.z();
  REQUIRE(partner.tick(view_at(2.1)));
  CHECK(partner.second_hand(2.1));
  CHECK(partner.tick(view_at(2.2, -0.002))->force_W.z() > one_n + 5.0);
  CHECK_FALSE(partner.tick(view_at(3.0)));
  CHECK_FALSE(partner.second_hand(3.1));
  CHECK(partner.hold_to_show(4.0)->leaves);
}

TEST_CASE("an obliging partner goes where he is asked to, another one stays") {
  const bool obliging = GENERATE(true, false);
  ScenarioPartner script = at_origin("compliant");
  script.obliging = obliging;
  script.events = {{50.0, "let-go", std::nullopt}};
  SimPartner partner(script, {}, 1);
  REQUIRE(partner.tick(view_at(2.0)));
  CHECK(partner.ask({0.4, 0.2, 0.4}, 2.0) == obliging);
  CHECK(partner.tick(view_at(2.9))->at_W.y() == 0.0);  // he hears it
  const auto later = partner.tick(view_at(4.5));
  REQUIRE(later);
  CHECK(later->at_W.y() == Approx(obliging ? 0.2 : 0.0));
  if (!obliging) return;
  CHECK(partner.hold_to_show(4.5)->grasp_T.y() == 0.2);
  // once more, and his script is forgotten
  REQUIRE(partner.ask({0.4, -0.2, 0.4}, 5.0));
  CHECK_FALSE(partner.tick(view_at(6.5)));
  CHECK(partner.tick(view_at(7.5))->at_W.y() == Approx(-0.2));
  CHECK(partner.tick(view_at(60.0)));
}

TEST_CASE("an event before he arrives means that he does not hold at all") {
  ScenarioPartner script = at_origin("compliant");
  script.events = {{0.5, "let-go", std::nullopt}};
  SimPartner partner(script, {}, 1);
  for (const double t : {0.4, 0.6, 1.0, 1.5}) CHECK_FALSE(partner.tick(view_at(t)));
}

TEST_CASE("a compliant partner lifts along after his reaction time, not before") {
  SimPartner partner(at_origin("compliant"), {}, 1);
  double before = 0.0, after = 0.0;
  // at 2 s the object turns about his hand until the robot's side is 2 cm higher
  const Eigen::AngleAxisd turn(std::asin(0.02 / 0.8), Vec3::UnitY());
  for (int ms = 1000; ms < 2600; ++ms) {
    PartnerView view = view_at(0.001 * ms);
    if (ms >= 2000) {
      const Vec3 hand(0.4, 0.0, 0.4);
      view.X_WT.linear() = turn.toRotationMatrix();
      view.X_WT.translation() = hand - view.X_WT.linear() * hand;
    }
    const auto action = partner.tick(view);
    REQUIRE(action);
    if (ms >= 2020 && ms < 2140) before += action->force_W.z() / 120;
    if (ms >= 2500) after += action->force_W.z() / 100;
  }
  CHECK(std::abs(before) < 2.0);
  CHECK(after > 100.0);
}

TEST_CASE("no partner is stronger than 250 N or turns harder than 1.5 N m") {
  SimPartner partner(at_origin("compliant"), {}, 1);
  REQUIRE(partner.tick(view_at(1.0)));
  PartnerView far = view_at(1.001, -0.5);
  far.X_WT.linear() = Eigen::AngleAxisd(1.0, Vec3::UnitY()).toRotationMatrix();
  far.v_W = Vec3(5.0, 0.0, 0.0);
  const auto action = partner.tick(far);
  REQUIRE(action);
  CHECK(action->force_W.norm() == Approx(250.0));
  CHECK(action->torque_W.norm() == Approx(1.5));
}

TEST_CASE("a leader waits one second after the fingers have locked, then goes up, holds and comes down") {
  ScenarioTask task;
  task.height = 0.06;
  task.hold_s = 1.0;
  SimPartner partner(at_origin("leader"), task, 1);
  const auto mean_force = [&](int from_ms, int to_ms) {
    double sum = 0.0;
    for (int ms = from_ms; ms < to_ms; ++ms) {
      PartnerView view = view_at(0.001 * ms);
      if (ms < 2000) view.robot_T.reset();
      sum += partner.tick(view)->force_W.z() / (to_ms - from_ms);
    }
    return sum;
  };
  CHECK(std::abs(mean_force(1000, 2000)) < 1.0);
  CHECK(std::abs(mean_force(2000, 3000)) < 1.0);  // locked at 2 s
  CHECK(mean_force(3000, 4000) > 20.0);
  CHECK(mean_force(5000, 6000) > 200.0);
  (void)mean_force(6000, 8100);
  CHECK(std::abs(mean_force(8100, 9000)) < 1.0);
}

TEST_CASE("the hand trembles by half a millimetre, as the seed says") {
  SimPartner a(at_origin("compliant"), {}, 1), b(at_origin("compliant"), {}, 1),
      c(at_origin("compliant"), {}, 2);
  double most = 0.0, apart = 0.0;
  for (int ms = 1000; ms < 2000; ++ms) {
    const Vec3 fa = a.tick(view_at(0.001 * ms))->force_W, fb = b.tick(view_at(0.001 * ms))->force_W,
               fc = c.tick(view_at(0.001 * ms))->force_W;
    CHECK(fa == fb);
    most = std::max(most, std::abs(fa.z()));
    apart = std::max(apart, (fa - fc).norm());
  }
  CHECK(most == Approx(7000.0 * 0.0005).epsilon(0.02));
  CHECK(apart > 1.0);
}

}  // namespace
}  // namespace colift::sim_hal
