// Ways: followed, halted, resumed, run back, refused.
#include <cmath>

#include "setpoint_rig.hpp"

using namespace colift;
using namespace colift::control;
using namespace colift::control::test;

TEST_CASE("a way is followed to its goal in its own time", "[cycle]") {
  Rig rig;
  const auto w = way({home(), there()});
  REQUIRE(rig.cycle.follow(w));
  double before = 0.0;
  double t = 0.0;
  while (!rig.cycle.done()) {
    rig.step();
    t += rig.period_s;
    CHECK(rig.cycle.progress() >= before);
    before = rig.cycle.progress();
    CHECK((rig.last.q_rad - w->sample(t).q_rad).cwiseAbs().maxCoeff() < 1e-9);
    REQUIRE(t < 20.0);
  }
  CHECK(rig.last.q_rad == w->goal());
  CHECK(t == Approx(w->duration_s()).margin(3 * rig.period_s));
  CHECK(rig.cycle.progress() == 1.0);
  const planner::MotionLimits planned;
  CHECK(rig.fastest <= planned.velocity_rad_s.maxCoeff() * 1.001);
  CHECK(rig.hardest <= planned.acceleration_rad_s2.maxCoeff() * 1.001);
}

TEST_CASE("hold stops on the way, within limits, and the way can be resumed or run back", "[cycle]") {
  const double part = GENERATE(0.05, 0.3, 0.5, 0.8, 0.97);
  const bool back = GENERATE(false, true);
  Rig rig;
  const auto w = way({home(), there(), beyond()});
  REQUIRE(rig.cycle.follow(w));
  while (rig.cycle.progress() < part) rig.step();
  rig.cycle.hold();
  const double t = rig.run();
  CAPTURE(part, back, t);
  CHECK(t < 0.35);
  CHECK(off_path(*w, rig.last.q_rad) < 1e-6);
  const JointVector halted = rig.last.q_rad;
  rig.steps(100);
  CHECK(rig.last.q_rad == halted);
  if (back)
    rig.cycle.back(0.5);
  else
    rig.cycle.resume();
  for (int i = 0; i < 20000 && !(rig.cycle.done() && i > 0); ++i) {
    rig.step();
    if (i % 50 == 0) CHECK(off_path(*w, rig.last.q_rad) < 1e-6);
  }
  CHECK(rig.last.q_rad == (back ? w->start() : w->goal()));
  CHECK(rig.hardest <= rig.limits.acceleration_rad_s2 + planner::MotionLimits{}.acceleration_rad_s2[0]);
}

TEST_CASE("from its end, too, a way can be run back", "[cycle]") {
  Rig rig;
  const auto w = way({home(), there()});
  REQUIRE(rig.cycle.follow(w));
  rig.run();
  rig.cycle.back();
  CHECK_FALSE((rig.step(), rig.cycle.done()));
  rig.run();
  CHECK(rig.last.q_rad == home());
  CHECK(rig.cycle.progress() == 0.0);
}

TEST_CASE("from a quarter metre a second the palm rests within 40 mm and 0.3 s", "[cycle]") {
  const auto palm = [](const JointVector& q) { return hal::hand_pose(robot(), q).translation().eval(); };
  std::mt19937_64 bits(9);
  const auto draw = [&](double most) {
    return most * (2.0 * static_cast<double>(bits() >> 11) * 0x1p-53 - 1.0);
  };
  int stops = 0;
  for (int i = 0; i < 100; ++i) {
    Rig rig;
    JointVector goal = home();
    for (int j = 0; j < hal::kArmJoints; ++j) goal[j] += draw(1.0);
    const auto w = way({home(), goal});
    REQUIRE(rig.cycle.follow(w));
    rig.cycle.resume(0.4);
    hal::Vec3 before = palm(rig.last.q_rad);
    double speed = 0.0;
    while (!rig.cycle.done()) {
      rig.step();
      const hal::Vec3 now = palm(rig.last.q_rad);
      speed = (now - before).norm() / rig.period_s;
      before = now;
      if (speed > 0.2) break;
    }
    if (speed <= 0.2 || speed > 0.25) continue;
    ++stops;
    rig.cycle.hold();
    CHECK(rig.run() <= 0.30);
    CHECK((palm(rig.last.q_rad) - before).norm() <= 0.040);
  }
  CHECK(stops > 30);
}

TEST_CASE("a way is refused that starts elsewhere, while the arm moves, or that is none", "[cycle]") {
  Rig rig;
  CHECK(rig.cycle.follow(nullptr).error().code == hal::ErrorCode::BadInput);
  const auto elsewhere = rig.cycle.follow(way({there(), home()}));
  REQUIRE_FALSE(elsewhere);
  CHECK(elsewhere.error().code == hal::ErrorCode::BadInput);
  CHECK_THAT(elsewhere.error().detail,
             Catch::Matchers::Contains("0.9000 rad from the commanded position in A7"));
  REQUIRE(rig.cycle.follow(way({home(), there()})));
  rig.steps(300);
  CHECK(rig.cycle.follow(way({rig.last.q_rad, home()})).error().code == hal::ErrorCode::NotReady);
  SetpointGenerator fresh(robot(), TaskConfig{});
  CHECK(fresh.follow(way({home(), there()})).error().code == hal::ErrorCode::NotReady);
}

TEST_CASE("a way that starts a little beside the command is joined without a step", "[cycle]") {
  Rig rig;
  const JointVector beside = home() + JointVector::Constant(0.02);
  const auto w = way({beside, there()});
  REQUIRE(rig.cycle.follow(w));
  rig.run();
  CHECK(rig.last.q_rad == w->goal());
  CHECK(rig.hardest < 3.0);
}
