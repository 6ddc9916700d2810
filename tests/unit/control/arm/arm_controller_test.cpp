// A lift in the arm's cycle: cut off and taken up again, slow, at the end of the reach; and no page faults.
#include "control/arm/arm_controller.hpp"

#include <sys/mman.h>
#include <sys/resource.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <chrono>
#include <cmath>
#include <string>
#include <vector>

#include "hal/os/realtime.hpp"

using namespace colift;
using namespace colift::control;
using namespace std::chrono_literals;
using hal::JointVector;

namespace {

const hal::RobotModel& robot() {
  return hal::built_in_robot();
}

/// An arm that is where it was commanded one cycle ago, and what was commanded.
struct Rig {
  explicit Rig(const TaskConfig& config = {}) : task(config) {
    state.q_rad << 0.0, 0.35, 0.0, 1.75, 0.0, -0.9, 0.0;
    state.may_command = true;
    step();
  }

  void step() {
    state.measured_at += 2ms;
    motion.measured(state);
    if (const auto command = motion.command()) {
      const JointVector v = (command->q_rad - state.q_rad) / 0.002;
      if (motion.view().starts == starts) {
        fastest = std::max(fastest, v.cwiseAbs().maxCoeff());
        hardest = std::max(hardest, ((v - last_v) / 0.002).cwiseAbs().maxCoeff());
      }
      last_v = v;
      state.q_rad = state.q_commanded_rad = command->q_rad;
    } else {
      last_v.setZero();
    }
    starts = motion.view().starts;
  }
  void steps(int n) {
    for (int i = 0; i < n; ++i) step();
  }
  void ask(ArmRequest::Kind kind, double number = 0.0, double time_s = 0.0) {
    motion.take({kind, ++id, nullptr, number, LiftController::Role::Lead, time_s});
  }
  void ask_lift() { ask(ArmRequest::Kind::StartLift, task.lift_height_m, task.lift_s); }
  /// Steps until the lift is at rest; returns how long it took (s).
  double lift(double most_s = 30.0) {
    int n = 0;
    do {
      step();
      ++n;
    } while (!motion.view().lift_at_rest && 0.002 * n < most_s);
    return 0.002 * n;
  }
  [[nodiscard]] double palm_m() const { return hal::hand_pose(robot(), state.q_rad).translation().z(); }

  TaskConfig task;
  ArmController motion{robot(), planner::arm_geometry(robot()).value(), task, LoadConfig{}};
  hal::ArmState state;
  JointVector last_v = JointVector::Zero();
  double fastest = 0.0, hardest = 0.0;
  std::uint32_t starts = 0, id = 0;
};

}  // namespace

TEST_CASE("what has followed a push brakes where it is, and does not return") {
  const planner::ArmGeometry arm = planner::arm_geometry(robot()).value();
  ForceMonitorConfig force;
  ArmController motion(robot(), arm, TaskConfig{}, LoadConfig{}, {}, force);
  hal::ArmState state;
  state.q_rad << 0.0, 0.35, 0.0, 1.75, 0.0, -0.9, 0.0;
  state.may_command = true;
  double commanded = state.q_rad[1], least_step = 0.0;
  const auto cycles = [&](int n, double push_nm, double rad_s) {
    for (int i = 0; i < n; ++i) {
      state.measured_at += 2ms;
      state.q_rad[1] += 0.002 * rad_s;
      state.tau_external_nm[1] = push_nm;
      motion.measured(state);
      const auto command = motion.command();
      REQUIRE(command);
      least_step = std::min(least_step, command->q_rad[1] - commanded);
      commanded = command->q_rad[1];
    }
  };
  cycles(300, 0.0, 0.0);
  const double from = commanded;
  cycles(100, 80.0, 2.5);
  REQUIRE(motion.view().force);
  CHECK(commanded > from + 0.05);
  cycles(500, 0.0, 0.0);
  CHECK(least_step > -1e-6);
  CHECK(motion.view().at_rest);
}

TEST_CASE("a lift that is cut off stands, and goes on to its height from where the arm came to rest") {
  const int after = GENERATE(100, 400, 700, 1200);
  CAPTURE(after);
  Rig rig;
  const double floor = rig.palm_m();
  rig.ask_lift();
  rig.steps(after);
  rig.state.may_command = false;
  rig.steps(20);
  rig.state.q_rad[1] += 0.004;  // it sagged
  const double sagged = rig.palm_m();
  const JointVector before = rig.state.q_rad;
  rig.state.may_command = true;
  rig.step();
  CHECK((rig.state.q_rad - before).norm() == 0.0);
  rig.hardest = rig.fastest = 0.0;
  rig.step();
  CHECK(rig.motion.view().height_m == Approx(sagged - floor).margin(5e-4));
  CHECK_FALSE(rig.motion.view().lift_at_rest);
  rig.lift();
  CHECK(rig.palm_m() - floor == Approx(rig.task.lift_height_m).margin(2e-4));
  CHECK(rig.fastest < 0.3);
  CHECK(rig.hardest < 2.0);
  rig.ask(ArmRequest::Kind::Lower);
  rig.lift();
  CHECK(rig.palm_m() - floor == Approx(0.0).margin(2e-4));
}

TEST_CASE("time does not run on for a lift whose arm is not commanded") {
  Rig rig;
  rig.ask_lift();
  rig.steps(300);
  const double height = rig.motion.view().height_m;
  rig.state.may_command = false;
  rig.steps(1000);
  CHECK(rig.motion.view().height_m == height);
  CHECK_FALSE(rig.motion.view().lift_at_rest);
}

TEST_CASE("a lift under a warning takes longer, and ends at the same height") {
  Rig planned;
  const double floor = planned.palm_m();
  planned.ask_lift();
  const double planned_s = planned.lift();

  const bool asked = GENERATE(false, true);
  Rig rig;
  if (asked)
    rig.ask(ArmRequest::Kind::Slow, 1.0);
  else
    rig.state.slow = true;
  rig.ask_lift();
  const double t = rig.lift();
  CHECK(rig.motion.view().slow);
  CHECK(t > 0.85 * planned_s / rig.task.slow_fraction);
  CHECK(t < 1.1 * planned_s / rig.task.slow_fraction);
  CHECK(rig.palm_m() - floor == Approx(rig.task.lift_height_m).margin(2e-4));
}

TEST_CASE("a slow lift that was ended stays where it is, goes on to its height and comes down") {
  Rig rig;
  const double floor = rig.palm_m();
  rig.ask(ArmRequest::Kind::StartLift, 0.03, 15.0);
  while (rig.motion.view().height_m < 0.008) rig.step();
  rig.ask(ArmRequest::Kind::Stay);
  rig.steps(10);
  CHECK(rig.motion.view().lift_at_rest);
  const double stayed = rig.palm_m() - floor;
  rig.steps(500);
  CHECK(rig.palm_m() - floor == Approx(stayed).margin(1e-4));
  CHECK(stayed == Approx(0.008).margin(5e-4));
  SECTION("also when it is cut off there and sagged: without a step") {
    rig.state.may_command = false;
    rig.steps(20);
    rig.state.q_rad[1] += 0.004;
    rig.state.may_command = true;
    rig.step();
    rig.hardest = rig.fastest = 0.0;
    rig.steps(600);
    CHECK(rig.fastest < 0.3);
    CHECK(rig.palm_m() - floor == Approx(stayed).margin(5e-4));
  }
  rig.ask(ArmRequest::Kind::RaiseOn, 0.05, 4.0);
  CHECK_FALSE(rig.motion.view().lift_at_rest);
  const double took_s = rig.lift();
  CHECK(took_s == Approx(4.0).margin(0.1));
  CHECK(rig.palm_m() - floor == Approx(0.05).margin(5e-4));
  CHECK(rig.hardest < 2.0);
  rig.ask(ArmRequest::Kind::Lower);
  rig.lift();
  CHECK(rig.palm_m() - floor == Approx(0.0).margin(5e-4));
}

TEST_CASE("at the end of its reach a lift slows to rest before the margin, says so, and comes down again") {
  TaskConfig task;
  task.lift_height_m = 0.5;  // no plan would allow it: the arm is straight before
  task.lift_s = 8.0;
  Rig rig(task);
  const double floor = rig.palm_m();
  rig.ask_lift();
  for (int i = 0; i < 5000 && !rig.motion.view().end_of_reach; ++i) rig.step();
  REQUIRE(rig.motion.view().end_of_reach);
  rig.steps(2000);  // near the straight arm the joints lag behind the palm
  const JointVector at = rig.state.q_rad;
  rig.steps(500);
  CHECK((rig.state.q_rad - at).norm() < 1e-9);
  const double margin = SetpointLimits{}.limit_margin_rad;
  for (int i = 0; i < hal::kArmJoints; ++i) {
    CHECK(at[i] >= robot().lower_rad()[i] + margin - 1e-9);
    CHECK(at[i] <= robot().upper_rad()[i] - margin + 1e-9);
  }
  CHECK(rig.palm_m() - floor > 0.05);
  CHECK(rig.hardest <= SetpointLimits{}.acceleration_rad_s2 + 1e-6);
  rig.ask(ArmRequest::Kind::Lower);
  rig.lift();
  CHECK_FALSE(rig.motion.view().end_of_reach);
  CHECK(rig.palm_m() - floor == Approx(0.0).margin(1e-3));
}

TEST_CASE("an arm that is pushed far away from its set point is not asked for more than its joints give") {
  Rig rig;
  rig.steps(100);
  hal::ArmState pushed = rig.state;
  pushed.measured_at += 2ms;
  pushed.q_rad[3] += 0.2;
  rig.motion.measured(pushed);
  const auto command = rig.motion.command();
  REQUIRE(command);
  const JointVector effort_nm = robot().effort_nm();
  const JointVector asked_nm =
      command->stiffness_nm_rad.cwiseProduct(command->q_rad - pushed.q_rad) + command->tau_superposed_nm;
  for (int i = 0; i < hal::kArmJoints; ++i) CHECK(std::abs(asked_nm[i]) < 0.91 * effort_nm[i]);
  CHECK(std::abs(asked_nm[3]) > 0.8 * effort_nm[3]);
  CHECK(command->stiffness_nm_rad[3] < 0.5 * rig.task.stiffness_nm_rad);
  CHECK(command->stiffness_nm_rad[1] == Approx(rig.task.stiffness_nm_rad));
}

TEST_CASE("after warm-up a cycle of the arm faults no page in") {
  Rig rig;
  const auto job = [&] {
    rig.ask_lift();
    rig.steps(1500);
    rig.state.may_command = false;
    rig.steps(20);
    rig.state.may_command = true;
    rig.steps(1500);
    rig.ask(ArmRequest::Kind::Lower);
    rig.steps(1500);
    rig.ask(ArmRequest::Kind::Hold);
    rig.steps(100);
  };
  // as the arm's thread does: memory locked, stack and heap touched; then what the cycle itself needs is
  // there
  const auto granted = hal::ask_for_realtime(
      {.priority = 0, .lock_memory = true, .stack_bytes = 262144, .heap_bytes = 1 << 20});
  job();
  rusage before{}, after{};
  REQUIRE(::getrusage(RUSAGE_THREAD, &before) == 0);
  job();
  REQUIRE(::getrusage(RUSAGE_THREAD, &after) == 0);
  (void)::munlockall();
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  constexpr long kOfSanitizer = 8;  // its own books
#else
  constexpr long kOfSanitizer = 0;
#endif
  INFO((granted.words.empty() ? std::string() : granted.words.front()));
  CHECK(after.ru_minflt - before.ru_minflt <= kOfSanitizer);
  CHECK(after.ru_majflt - before.ru_majflt == 0);
}
