// What is left of a motion when the arm's controller took no commands for a while, or warns.
#include <cmath>

#include "setpoint_rig.hpp"

using namespace colift;
using namespace colift::control;
using namespace colift::control::test;

TEST_CASE("after a gap or a loss of command mode the arm holds where it is; nothing is resumed", "[cycle]") {
  const bool gap = GENERATE(false, true);
  Rig rig;
  const auto w = way({home(), there()});
  REQUIRE(rig.cycle.follow(w));
  rig.cycle.superpose(JointVector::Constant(5.0));
  rig.steps(600);
  const std::uint32_t starts = rig.cycle.starts();
  rig.state.q_rad[0] -= 0.05;
  if (gap) {
    rig.state.measured_at += std::chrono::milliseconds(200);
  } else {
    rig.state.may_command = false;
    rig.step();
    rig.state.q_rad[0] -= 0.01;
    rig.state.may_command = true;
  }
  const JointVector here = rig.state.q_rad;
  rig.step();
  CHECK(rig.cycle.starts() == starts + 1);
  CHECK(rig.last.q_rad == here);
  CHECK(rig.last.tau_superposed_nm.norm() == 0.0);
  // 0.05 rad away it was moved, and the way is lost
  CHECK_FALSE(rig.cycle.resume());
  CHECK_FALSE(rig.cycle.back());
  CHECK_FALSE(rig.cycle.done());
  rig.steps(500);
  CHECK(rig.last.q_rad == here);
  CHECK(rig.last.tau_superposed_nm.norm() == 0.0);
}

TEST_CASE("a state that came twice gets the same answer", "[cycle]") {
  Rig rig;
  REQUIRE(rig.cycle.follow(way({home(), there()})));
  rig.steps(300);
  const ImpedanceCommand again = rig.cycle.step(rig.state);
  const ImpedanceCommand more = rig.cycle.step(rig.state);
  CHECK(again.q_rad == rig.last.q_rad);
  CHECK(more.q_rad == rig.last.q_rad);
}

namespace {

/// Cuts the way off for 40 ms in which the arm comes to rest where it was, a little beside the way.
void cut_off(Rig& rig, double beside_rad) {
  rig.state.may_command = false;
  rig.steps(40);
  rig.state.q_rad += beside_rad * (JointVector() << 1, -0.5, 0.2, -1, 0.7, 0.3, -0.1).finished();
  rig.state.may_command = true;
  rig.step();
}

}  // namespace

TEST_CASE("a way that was cut off is taken up where the arm stands, from rest and to its end", "[cycle]") {
  const double part = GENERATE(0.0, 0.02, 0.3, 0.7, 0.999);
  const double beside = GENERATE(0.0, 0.008, -0.025);
  const bool back = GENERATE(false, true);
  CAPTURE(part, beside, back);
  Rig rig;
  const auto w = way({home(), there(), beyond()});
  REQUIRE(rig.cycle.follow(w));
  while (rig.cycle.progress() < part) rig.step();
  cut_off(rig, beside);
  CHECK_FALSE(rig.cycle.done());  // it stands, but not where it was sent
  const JointVector here = rig.last.q_rad;
  rig.steps(200);
  CHECK(rig.last.q_rad == here);
  CHECK(rig.cycle.progress() == Approx(part).margin(0.02));
  rig.fastest = rig.hardest = 0.0;
  REQUIRE((back ? rig.cycle.back() : rig.cycle.resume()));
  rig.step();
  CHECK((rig.last.q_rad - here).cwiseAbs().maxCoeff() < 1e-5);
  rig.run();
  CHECK((rig.last.q_rad - (back ? w->start() : w->goal())).norm() < 1e-12);
  CHECK(rig.hardest <= rig.limits.resume_rad_s2 + planner::MotionLimits{}.acceleration_rad_s2[0] + 0.7);
  CHECK(rig.fastest <= 1.1 * planner::MotionLimits{}.velocity_rad_s[0]);
}

TEST_CASE("a way can be cut off and taken up again as often as it happens", "[cycle]") {
  Rig rig;
  const auto w = way({home(), there(), beyond()});
  REQUIRE(rig.cycle.follow(w));
  int times = 0;
  for (; !rig.cycle.done() && times < 100; ++times) {
    rig.steps(600);  // longer than it takes to be back on the way
    if (rig.cycle.done()) break;
    cut_off(rig, 0.004);
    REQUIRE(rig.cycle.resume());
  }
  CHECK(times > 2);
  CHECK(times < 100);
  CHECK(rig.last.q_rad == w->goal());
}

TEST_CASE("a halted way that is cut off stays halted", "[cycle]") {
  Rig rig;
  REQUIRE(rig.cycle.follow(way({home(), there()})));
  rig.steps(400);
  rig.cycle.hold();
  rig.steps(400);
  cut_off(rig, 0.0);
  const JointVector here = rig.last.q_rad;
  rig.steps(200);
  CHECK(rig.last.q_rad == here);
  rig.cycle.hold();
  CHECK(rig.cycle.done());
}

TEST_CASE("after a set point was served there is no trajectory to go back to", "[cycle]") {
  Rig rig;
  REQUIRE(rig.cycle.follow(way({home(), there()})));
  rig.run();
  rig.cycle.servo(rig.last.q_rad, JointVector::Zero());
  rig.steps(10);
  cut_off(rig, 0.0);
  CHECK_FALSE(rig.cycle.back());
}

TEST_CASE("while the controller warns a way runs at the slow part of its speed, smoothly there and back",
          "[cycle]") {
  const bool asked = GENERATE(false, true);
  CAPTURE(asked);
  const auto w = way({home(), there(), beyond()});
  Rig fast;
  REQUIRE(fast.cycle.follow(w));
  const double planned_s = fast.run();

  Rig rig;
  REQUIRE(rig.cycle.follow(w));
  const auto warn = [&](bool on) { asked ? rig.cycle.go_slow(on) : void(rig.state.slow = on); };
  while (rig.cycle.progress() < 0.3) rig.step();
  warn(true);
  rig.steps(600);  // on the way to the lower speed
  const double from = rig.cycle.progress();
  rig.steps(1000);
  CHECK((rig.cycle.progress() - from) * w->duration_s() == Approx(rig.task.slow_fraction).margin(0.01));
  CHECK(rig.cycle.pace() == Approx(rig.task.slow_fraction));
  warn(false);
  rig.steps(10);
  CHECK(rig.cycle.slow());  // a warning that comes and goes is one
  const double t = rig.run();
  CHECK(rig.last.q_rad == w->goal());
  CHECK(rig.cycle.pace() == 1.0);
  CHECK(t < planned_s);
  CHECK(rig.hardest <= rig.limits.acceleration_rad_s2 + planner::MotionLimits{}.acceleration_rad_s2[0]);
}

TEST_CASE("a way that begins under a warning is slow from its start", "[cycle]") {
  Rig rig;
  rig.state.slow = true;
  rig.steps(10);
  const auto w = way({home(), there()});
  REQUIRE(rig.cycle.follow(w));
  CHECK(rig.run() > 0.8 / rig.task.slow_fraction * w->duration_s());
  CHECK(rig.last.q_rad == w->goal());
}

TEST_CASE("a speed scale of 0 stands still on the path, jerk within the limits, and any other continues",
          "[cycle]") {
  const auto w = way({home(), there(), beyond()});
  Rig rig;
  REQUIRE(rig.cycle.follow(w));
  while (rig.cycle.progress() < 0.3) rig.step();
  rig.cycle.set_scale(0.4);
  rig.steps(600);
  const double from = rig.cycle.progress();
  rig.steps(1000);
  CHECK((rig.cycle.progress() - from) * w->duration_s() == Approx(0.4).margin(0.01));
  rig.cycle.set_scale(0.0);
  rig.steps(800);
  CHECK(rig.cycle.at_rest());
  CHECK_FALSE(rig.cycle.done());  // it waits, it has not arrived
  CHECK(off_path(*w, rig.last.q_rad) < 1e-6);
  const JointVector stood = rig.last.q_rad;
  rig.steps(3000);
  CHECK(rig.last.q_rad == stood);
  rig.cycle.set_scale(1.0);
  (void)rig.run();
  CHECK(rig.last.q_rad == w->goal());
  CHECK(rig.hardest <= rig.limits.acceleration_rad_s2 + planner::MotionLimits{}.acceleration_rad_s2[0]);
}

TEST_CASE("a scale that is no number stands still", "[cycle]") {
  Rig rig;
  REQUIRE(rig.cycle.follow(way({home(), there()})));
  rig.cycle.set_scale(std::numeric_limits<double>::quiet_NaN());
  rig.steps(500);
  const hal::JointVector stood = rig.last.q_rad;  // the speed went down with its ramp
  CHECK(rig.cycle.progress() < 0.05);
  rig.steps(500);
  CHECK(rig.last.q_rad == stood);
  rig.cycle.set_scale(7.0);
  (void)rig.run();
  CHECK(rig.last.q_rad == there());
}
