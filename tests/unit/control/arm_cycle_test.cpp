#include "control/arm_cycle.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <limits>
#include <random>

#include "allocations.hpp"
#include "hal/guarded_arm.hpp"

using namespace colift;
using namespace colift::control;
using hal::ImpedanceCommand;
using hal::JointVector;
using planner::Trajectory;

namespace {

const hal::RobotModel& robot() {
  return hal::built_in_robot();
}

JointVector home() {
  return (JointVector() << 0.3, 0.6, -0.2, -1.3, 0.4, 0.9, -0.5).finished();
}

JointVector there() {
  return (JointVector() << -0.5, 0.9, 0.3, -0.7, -0.2, 1.2, 0.4).finished();
}

JointVector beyond() {
  return there() + (JointVector() << 0.3, -0.4, 0.5, -0.3, 0.6, -0.5, 0.2).finished();
}

std::shared_ptr<const Trajectory> way(std::vector<JointVector> path) {
  auto made = planner::make_trajectory(path, planner::MotionLimits{}, 0.0);
  REQUIRE(made);
  return std::make_shared<const Trajectory>(*made);
}

/// How far q is from the nearest point of the way (rad).
double off_the_way(const Trajectory& t, const JointVector& q) {
  const auto off = [&](double s) { return (t.sample(s).q_rad - q).norm(); };
  double best_s = 0.0;
  for (double s = 0.0; s <= t.duration_s(); s += 0.01)
    if (off(s) < off(best_s)) best_s = s;
  for (double step = 0.01; step > 1e-9;) {
    const double better = off(best_s - step) < off(best_s + step) ? best_s - step : best_s + step;
    if (off(better) < off(best_s))
      best_s = better;
    else
      step *= 0.5;
  }
  return off(best_s);
}

/// An arm that is where it was commanded one cycle ago, and a strict look at every command.
struct Rig {
  double period_s = 0.001;
  TaskConfig task;
  CycleLimits limits;
  ArmCycle cycle{robot(), task, limits};
  hal::ArmState state;
  ImpedanceCommand last;
  JointVector v = JointVector::Zero();
  double fastest = 0.0, hardest = 0.0;

  Rig() {
    state.may_command = true;
    state.q_rad = home();
    step();
  }

  void step() {
    state.measured_at += hal::Timestamp(static_cast<std::int64_t>(period_s * 1e9 + 0.5));
    const std::uint32_t starts = cycle.starts();
    const ImpedanceCommand c = cycle.step(state);
    REQUIRE(c.q_rad.allFinite());
    if (cycle.starts() == starts && state.may_command) {
      const JointVector now = (c.q_rad - last.q_rad) / period_s;
      fastest = std::max(fastest, now.cwiseAbs().maxCoeff());
      hardest = std::max(hardest, ((now - v) / period_s).cwiseAbs().maxCoeff());
      v = now;
    } else {
      v.setZero();
    }
    last = c;
    state.q_rad = c.q_rad;
  }

  void steps(int n) {
    for (int i = 0; i < n; ++i) step();
  }

  /// Steps until done; returns the time that it took (s).
  double run(double most_s = 20.0) {
    double t = 0.0;
    do {
      step();
      t += period_s;
    } while (!cycle.done() && t < most_s);
    CHECK(cycle.done());
    return t;
  }
};

const double kNan = std::numeric_limits<double>::quiet_NaN();

}  // namespace

TEST_CASE("the first command is the measured pose, and it is held", "[cycle]") {
  Rig rig;
  CHECK(rig.last.q_rad == home());
  CHECK(rig.last.tau_superposed_nm.norm() == 0.0);
  CHECK(rig.last.stiffness_nm_rad == JointVector::Constant(rig.task.stiffness_nm_rad));
  rig.state.q_rad[2] += 0.01;  // pushed: the set point stays, the spring pushes back
  const JointVector pushed = rig.state.q_rad;
  for (int i = 0; i < 50; ++i) {
    rig.state.q_rad = pushed;
    rig.step();
    CHECK(rig.last.q_rad == home());
  }
  CHECK(rig.cycle.done());
}

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
  CHECK(off_the_way(*w, rig.last.q_rad) < 1e-6);
  const JointVector halted = rig.last.q_rad;
  rig.steps(100);
  CHECK(rig.last.q_rad == halted);
  if (back)
    rig.cycle.back(0.5);
  else
    rig.cycle.resume();
  for (int i = 0; i < 20000 && !(rig.cycle.done() && i > 0); ++i) {
    rig.step();
    if (i % 50 == 0) CHECK(off_the_way(*w, rig.last.q_rad) < 1e-6);
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
  CHECK_THAT(elsewhere.error().detail, Catch::Matchers::Contains("0.9000 rad away from the command in A7"));
  REQUIRE(rig.cycle.follow(way({home(), there()})));
  rig.steps(300);
  CHECK(rig.cycle.follow(way({rig.last.q_rad, home()})).error().code == hal::ErrorCode::NotReady);
  ArmCycle fresh(robot(), TaskConfig{});
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

TEST_CASE("a set point that moves is served exactly; one that jumps, within limits and without overshoot",
          "[cycle]") {
  Rig rig;
  JointVector goal = home();
  for (int i = 0; i < 1000; ++i) {
    goal[1] = home()[1] + 0.05 * (1.0 - std::cos(i * 0.003));
    rig.cycle.servo(goal, JointVector::Zero());
    rig.step();
    CHECK((rig.last.q_rad - goal).cwiseAbs().maxCoeff() < 1e-9);
  }
  rig.cycle.servo(goal, JointVector::Zero());
  rig.run();
  const JointVector from = rig.last.q_rad;
  goal[0] += 0.4;
  goal[6] -= 0.01;
  double top = -1e9, bottom = 1e9;
  for (int i = 0; i < 2000; ++i) {
    rig.cycle.servo(goal, JointVector::Zero());
    rig.step();
    top = std::max(top, rig.last.q_rad[0]);
    bottom = std::min(bottom, rig.last.q_rad[6]);
  }
  CHECK((rig.last.q_rad - goal).cwiseAbs().maxCoeff() < 1e-6);
  CHECK(top <= goal[0] + 1e-9);
  CHECK(bottom >= goal[6] - 1e-9);
  CHECK(top > from[0]);
  CHECK(rig.hardest <= rig.limits.acceleration_rad_s2 + 1e-6);
}

TEST_CASE("a set point beyond a joint's end is served up to the margin, one that is not a number never",
          "[cycle]") {
  Rig rig;
  JointVector goal = home();
  goal[3] = -9.0;
  rig.cycle.servo(goal, JointVector::Zero());
  rig.steps(5000);
  CHECK(rig.last.q_rad[3] == Approx(robot().lower_rad()[3] + rig.limits.limit_margin_rad).margin(1e-6));
  CHECK(rig.last.q_rad[3] >= robot().lower_rad()[3] + rig.limits.limit_margin_rad - 1e-12);
  goal[3] = kNan;
  rig.cycle.servo(goal, JointVector::Zero());
  rig.cycle.servo(home(), JointVector::Constant(kNan));
  rig.cycle.superpose(JointVector::Constant(kNan));
  rig.cycle.set_stiffness(kNan);
  rig.steps(10);
  CHECK(rig.last.stiffness_nm_rad.allFinite());
}

TEST_CASE("hold ends the service of a set point at rest, and keeps the torque that bears the load",
          "[cycle]") {
  Rig rig;
  JointVector goal = home(), tau = JointVector::Zero();
  tau[1] = 12.0;
  for (int i = 0; i < 500; ++i) {
    goal[0] += 0.5 * rig.period_s;
    rig.cycle.servo(goal, tau);
    rig.step();
  }
  rig.cycle.hold();
  CHECK(rig.run() < 0.2);
  rig.steps(100);
  CHECK(rig.last.tau_superposed_nm == tau);
  CHECK(rig.hardest <= rig.limits.acceleration_rad_s2 + 1e-6);
}

TEST_CASE("torque and stiffness change with their slopes", "[cycle]") {
  Rig rig;
  JointVector tau = JointVector::Zero();
  tau[1] = 20.0;
  rig.cycle.superpose(tau);
  rig.cycle.set_stiffness(200.0);
  ImpedanceCommand before = rig.last;
  for (int i = 0; i < 1000; ++i) {
    rig.step();
    CHECK(std::abs(rig.last.tau_superposed_nm[1] - before.tau_superposed_nm[1]) <=
          rig.limits.torque_slope_nm_s * rig.period_s + 1e-12);
    CHECK(std::abs(rig.last.stiffness_nm_rad[0] - before.stiffness_nm_rad[0]) <=
          rig.limits.stiffness_slope_nm_rad_s * rig.period_s + 1e-9);
    before = rig.last;
  }
  CHECK(rig.last.tau_superposed_nm == tau);
  CHECK(rig.last.stiffness_nm_rad == JointVector::Constant(200.0));
}

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
  rig.cycle.resume();  // the way is behind, not ahead
  rig.cycle.back();
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

TEST_CASE("a push on the way is told within 10 ms, a lesser one or an old one is not", "[cycle]") {
  Rig rig;
  const auto torque = [&](double n) {
    const hal::ArmJacobian J = hal::jacobian(robot(), rig.state.q_rad, hal::Vec3::Zero());
    Eigen::Matrix<double, 6, 1> F;
    F << 0.6 * n, -0.8 * n, 0, 0, 0, 0;
    return JointVector(J.transpose() * F);
  };
  // what is felt at rest is the watch's zero
  const JointVector offset = torque(25.0);
  rig.state.tau_external_nm = offset;
  rig.steps(1000);
  REQUIRE(rig.cycle.follow(way({home(), there()})));
  rig.steps(400);
  CHECK_FALSE(rig.cycle.blocked());
  for (int i = 0; i < 200; ++i) {
    rig.state.tau_external_nm = offset + torque(20.0);
    rig.step();
  }
  CHECK_FALSE(rig.cycle.blocked());
  int cycles = 0;
  for (; !rig.cycle.blocked() && cycles < 100; ++cycles) {
    rig.state.tau_external_nm = offset + torque(60.0);
    rig.step();
  }
  CHECK(cycles <= 10);
  CHECK_THAT(control::describe(rig.cycle.blockage()), Catch::Matchers::Contains("limit 30 N"));

  // back out of it: the contact that is still there does not count, a new one does
  rig.cycle.hold();
  while (!rig.cycle.done()) rig.step();
  rig.cycle.back();
  rig.steps(20);
  CHECK_FALSE(rig.cycle.blocked());
  rig.state.tau_external_nm = offset;
  rig.steps(50);
  rig.state.tau_external_nm = offset + torque(60.0);
  rig.steps(20);
  CHECK(rig.cycle.blocked());
}

TEST_CASE("an arm that does not follow its command is told", "[cycle]") {
  Rig rig;
  REQUIRE(rig.cycle.follow(way({home(), there()})));
  rig.steps(200);
  const JointVector stuck = rig.state.q_rad;
  double lag = 0.0;
  for (int i = 0; i < 2000 && !rig.cycle.blocked(); ++i) {
    rig.step();
    lag = (rig.last.q_rad - stuck).cwiseAbs().maxCoeff();
    rig.state.q_rad = stuck;
  }
  CHECK(rig.cycle.blocked());
  CHECK(lag < rig.limits.follow_error_rad + 0.002);
  CHECK_THAT(control::describe(rig.cycle.blockage()), Catch::Matchers::Contains("A7 does not follow"));
}

TEST_CASE("answering a cycle allocates nothing", "[cycle]") {
  Rig rig;
  REQUIRE(rig.cycle.follow(way({home(), there()})));
  const auto before = allocations();
  for (int i = 0; i < 2000; ++i) {
    rig.state.measured_at += std::chrono::milliseconds(1);
    if (i == 500) rig.cycle.hold();
    if (i == 900) rig.cycle.back();
    if (i == 1500) rig.state.measured_at += std::chrono::milliseconds(100);
    if (i > 1700) rig.cycle.servo(there(), JointVector::Zero());
    rig.state.q_rad = rig.cycle.step(rig.state).q_rad;
  }
  CHECK(allocations() == before);
}

namespace {

/// Far end of the wire that only follows.
class IdealArm final : public hal::Arm {
 public:
  hal::ArmState state;
  hal::Result<> configure() override { return {}; }
  hal::Result<> activate() override { return {}; }
  void deactivate() noexcept override {}
  void stop() noexcept override {}
  hal::DeviceHealth health() const override { return {}; }
  hal::Result<hal::ArmState> wait_cycle() override { return state; }
  hal::Result<> command(const ImpedanceCommand& c) override {
    state.q_rad = c.q_rad;
    return {};
  }
};

}  // namespace

TEST_CASE("the last gate has nothing to refuse, whatever is asked of the cycle and when",
          "[cycle][property]") {
  std::mt19937_64 bits(77);
  const auto uniform = [&] { return static_cast<double>(bits() >> 11) * 0x1p-53; };
  auto owned = std::make_unique<IdealArm>();
  IdealArm& wire = *owned;
  hal::GuardedArm arm(std::move(owned), robot(), hal::GuardConfig{});
  ArmCycle cycle(robot(), TaskConfig{});
  wire.state.may_command = true;
  wire.state.q_rad = home();
  REQUIRE(arm.configure());
  REQUIRE(arm.activate());
  JointVector goal = home();
  int done = 0, ways = 0;
  for (int i = 0; i < 200'000; ++i) {
    const auto random_pose = [&] {
      JointVector q;
      for (int j = 0; j < hal::kArmJoints; ++j)
        q[j] =
            (robot().lower_rad()[j] + 0.1) * (1.0 - uniform()) + (robot().upper_rad()[j] - 0.1) * uniform();
      return q.cwiseMax((robot().lower_rad().array() + 0.1).matrix())
          .cwiseMin((robot().upper_rad().array() - 0.1).matrix())
          .eval();
    };
    const double dice = uniform();
    if (dice < 0.002)
      cycle.hold();
    else if (dice < 0.004)
      cycle.resume(uniform());
    else if (dice < 0.006)
      cycle.back(uniform());
    else if (dice < 0.007)
      goal = random_pose();
    else if (dice < 0.008)
      cycle.superpose(JointVector::Constant(200.0 * uniform() - 100.0));
    else if (dice < 0.009)
      cycle.set_stiffness(2000.0 * uniform());
    else if (dice < 0.03 && cycle.at_rest() && cycle.starts() > 0)
      ways += cycle.follow(way({cycle.commanded(), random_pose()})).has_value();
    const bool serve = (i / 20'000) % 2 == 1;
    if (serve) {
      for (int j = 0; j < hal::kArmJoints; ++j) goal[j] += 0.002 * (uniform() - 0.5);
      cycle.servo(goal, 150.0 * JointVector::Constant(uniform() - 0.5));
    }
    double step_s = 0.002;
    if (uniform() < 0.02) step_s *= 1 + static_cast<int>(5 * uniform());
    if (uniform() < 0.0005) step_s = 0.3;
    wire.state.measured_at += hal::Timestamp(static_cast<std::int64_t>(step_s * 1e9));
    wire.state.may_command = uniform() > 0.0005;
    const auto state = arm.wait_cycle();
    REQUIRE(state);
    const auto command = cycle.step(*state);
    if (!state->may_command) continue;
    const auto sent = arm.command(command);
    if (!sent) FAIL("cycle " << i << ": " << sent.error().text());
    done += cycle.done();
  }
  CHECK(ways > 20);
  CHECK(done > 1000);
}
