// The arm's cycle on its own: the same in step and in a thread, and never waiting for the task.

#include "control/arm/arm_commander.hpp"

#include <algorithm>
#include <atomic>
#include <catch2/catch.hpp>
#include <semaphore>
#include <thread>
#include <vector>

#include "../allocations.hpp"

using namespace colift;
using namespace colift::control;
using namespace std::chrono_literals;
using hal::JointVector;

namespace {

const hal::RobotModel& robot() {
  return hal::built_in_robot();
}

planner::ArmGeometry geometry() {
  return planner::arm_geometry(robot()).value();
}

JointVector home() {
  return (JointVector() << 0.0, 0.35, 0.0, 1.75, 0.0, -0.9, 0.0).finished();
}

planner::Trajectory way() {
  JointVector there = home();
  there[0] += 0.4;
  there[3] -= 0.3;
  return planner::make_trajectory(std::vector{home(), there}, planner::MotionLimits{}, 0.0).value();
}

constexpr int kAtOnce = 25;  // cycles of 2 ms between two of the task: half of what it may be late

/// How far q is from the nearest point of way() (rad).
double off_way(const JointVector& q) {
  const planner::Trajectory t = way();
  double least = 1e9;
  for (double s = 0.0; s <= t.duration_s(); s += 1e-3)
    least = std::min(least, (t.sample(s).q_rad - q).norm());
  return least;
}

/// An arm that follows at once and counts its cycles. With a gate it lets a cycle pass only when the test
/// says so; an arm that is left alone lets them all pass.
class CountedArm final : public hal::Arm {
 public:
  explicit CountedArm(bool gated) : gated_(gated) { state_.q_rad = state_.q_commanded_rad = home(); }

  hal::Result<> configure() override { return {}; }
  hal::Result<> activate() override { return {}; }
  void deactivate() noexcept override {}
  [[nodiscard]] hal::DeviceHealth health() const override { return {}; }
  hal::Result<hal::ArmState> wait_cycle() override {
    if (gated_) gate_.acquire();
    state_.measured_at += 2ms;
    const int cycle = ++cycles;
    if (cycle > silent_from) return hal::failure(hal::ErrorCode::Timeout, "arm", "silent");
    state_.may_command = true;
    state_.tau_external_nm.setZero();
    if (cycle > touched_from) state_.tau_external_nm[0] = 60.0;
    return state_;
  }
  hal::Result<> command(const hal::ImpedanceCommand& c) override {
    if (refuses) return hal::failure(hal::ErrorCode::LimitExceeded, "arm", "too fast");
    state_.q_rad = state_.q_commanded_rad = c.q_rad;
    if (sent.size() < sent.capacity()) sent.push_back(c.q_rad);
    return {};
  }
  void stop() noexcept override {}

  void let(int n) { gate_.release(n); }
  void open_gate() {
    gated_ = false;
    gate_.release(1);
  }

  std::atomic<int> cycles{0}, silent_from{1 << 30}, touched_from{1 << 30};
  std::atomic<bool> refuses{false};
  std::vector<JointVector> sent;

 private:
  std::atomic<bool> gated_;
  std::counting_semaphore<> gate_{0};
  hal::ArmState state_;
};

struct Rig {
  explicit Rig(Drive drive) : arm(drive == Drive::Thread), loop(arm, robot(), geometry(), task, load, drive) {
    arm.sent.reserve(20000);
    arm.let(1);
    REQUIRE(loop.start());
  }
  ~Rig() {
    arm.open_gate();
    loop.finish();
  }
  Rig(const Rig&) = delete;
  Rig& operator=(const Rig&) = delete;

  /// Lets n cycles pass in the arm's thread and waits until the task knows of them.
  void pass(int n) {
    loop.begin_cycle();  // after let_alone() the view is old
    for (std::uint64_t until = loop.view().cycles + loop.view().missed; n > 0; n -= kAtOnce) {
      until += static_cast<std::uint64_t>(std::min(n, kAtOnce));
      arm.let(std::min(n, kAtOnce));
      do loop.begin_cycle();
      while (loop.view().cycles + loop.view().missed < until);
    }
  }
  /// Lets n cycles pass while the task's thread does nothing at all.
  void let_alone(int n) {
    const int until = arm.cycles + n;
    arm.let(n);
    while (arm.cycles < until) std::this_thread::yield();
  }
  /// Reads the newest view, without any cycle of the arm after it.
  void look() {
    const std::uint32_t before = loop.view().stalls;
    for (int i = 0; i < 500 && loop.view().stalls == before; ++i) loop.begin_cycle();
  }

  TaskConfig task;
  LoadConfig load;
  CountedArm arm;
  ArmCommander loop;
};

}  // namespace

TEST_CASE("A thread sends exactly what the task would have sent in step") {
  Rig in_step(Drive::InStep), threaded(Drive::Thread);
  in_step.loop.begin_cycle();
  REQUIRE(in_step.loop.follow(way()));
  in_step.loop.end_cycle();
  REQUIRE(threaded.loop.follow(way()));
  threaded.pass(1);
  int steps = 1;
  for (; !in_step.loop.done() && steps < 5000; ++steps) {
    in_step.loop.begin_cycle();
    in_step.loop.end_cycle();
  }
  threaded.pass(steps - 1);
  CHECK(threaded.loop.done());
  CHECK((threaded.loop.commanded() - way().goal()).norm() < 1e-9);
  REQUIRE(in_step.arm.sent.size() == threaded.arm.sent.size());
  double off = 0.0;
  for (std::size_t i = 0; i < in_step.arm.sent.size(); ++i)
    off = std::max(off, (in_step.arm.sent[i] - threaded.arm.sent[i]).norm());
  CHECK(off == 0.0);
}

TEST_CASE("What the task asks about is its last request, never the one before") {
  Rig rig(Drive::Thread);
  rig.pass(2);
  CHECK(rig.loop.done());  // it holds
  REQUIRE(rig.loop.follow(way()));
  CHECK_FALSE(rig.loop.done());  // not even one cycle has passed
  CHECK(rig.loop.progress() == 0.0);
  rig.pass(1);
  CHECK_FALSE(rig.loop.done());
  CHECK_FALSE(rig.loop.at_rest());
}

TEST_CASE("A request that moves nothing does not keep the next way waiting") {
  Rig rig(Drive::Thread);
  rig.pass(2);
  rig.loop.end_tare();
  CHECK(rig.loop.done());
  CHECK(rig.loop.follow(way()));
}

TEST_CASE("A way that starts elsewhere, or while the arm moves, is refused at once") {
  Rig rig(Drive::Thread);
  const auto elsewhere =
      planner::make_trajectory(std::vector{way().goal(), home()}, planner::MotionLimits{}, 0.0).value();
  auto refused = rig.loop.follow(elsewhere);
  REQUIRE_FALSE(refused);
  CHECK_THAT(refused.error().detail, Catch::Contains("rad from the commanded position"));
  REQUIRE(rig.loop.follow(way()));
  rig.pass(20);
  refused = rig.loop.follow(way());
  REQUIRE_FALSE(refused);
  CHECK(refused.error().code == hal::ErrorCode::NotReady);
}

TEST_CASE("A contact stops the way in the cycle in which it is felt, without the task") {
  Rig rig(Drive::Thread);
  rig.pass(100);
  REQUIRE(rig.loop.follow(way()));
  rig.pass(150);
  CHECK_FALSE(rig.loop.at_rest());
  rig.arm.touched_from = rig.arm.cycles.load();
  rig.pass(200);  // the task asks for nothing
  CHECK(rig.loop.blocked());
  CHECK(rig.loop.at_rest());
  CHECK(rig.loop.progress() < 0.9);
  CHECK_THAT(rig.loop.why_blocked(), Catch::Contains("unexpected contact"));
}

TEST_CASE("An arm whose task stands still comes to rest on its path by itself, and stays") {
  Rig rig(Drive::Thread);
  rig.pass(10);
  REQUIRE(rig.loop.follow(way()));
  rig.pass(250);  // 0.5 s into the motion
  REQUIRE_FALSE(rig.loop.at_rest());
  const std::size_t moving = rig.arm.sent.size();
  rig.let_alone(200);  // 0.4 s in which the task's thread does not run
  rig.look();
  CHECK(rig.loop.stalled());
  CHECK(rig.loop.at_rest());
  CHECK(rig.loop.progress() < 0.9);
  CHECK(rig.loop.blocked());
  CHECK_THAT(rig.loop.why_blocked(), Catch::Contains("did not run for"));
  const auto& sent = rig.arm.sent;
  // on as planned for 0.1 s, then at rest within another 0.2 s
  CHECK((sent[moving + 48] - sent[moving + 47]).norm() > 0.0);
  CHECK((sent[moving + 150] - sent[moving + 149]).norm() == 0.0);
  for (std::size_t i = moving; i < sent.size(); ++i) CHECK(off_way(sent[i]) < 1e-3);

  SECTION("a task that only runs again moves nothing") {
    rig.pass(300);
    CHECK(rig.loop.stalled());
    CHECK(rig.loop.at_rest());
    CHECK((sent.back() - sent[sent.size() - 290]).norm() == 0.0);
  }
  SECTION("one that asks anew goes on to the end") {
    rig.pass(5);
    rig.loop.resume();
    for (int i = 0; i < 40 && !rig.loop.done(); ++i) rig.pass(50);
    CHECK_FALSE(rig.loop.stalled());
    CHECK(rig.loop.done());
    CHECK((rig.loop.commanded() - way().goal()).norm() < 1e-9);
    CHECK(rig.loop.view().stalls == 1);
  }
}

TEST_CASE("A task may compute for long while the arm is at rest, and ask then") {
  Rig rig(Drive::Thread);
  rig.pass(10);
  rig.let_alone(500);  // a second of planning
  REQUIRE(rig.loop.follow(way()));
  for (int i = 0; i < 40 && !rig.loop.done(); ++i) rig.pass(40);
  CHECK(rig.loop.done());
  CHECK(rig.loop.view().stalls == 0);
}

TEST_CASE("A lift stops for a late task, and goes on to its height when it is asked to") {
  Rig rig(Drive::Thread);
  rig.pass(10);
  rig.loop.start_lift(LiftController::Role::Lead, 0.05, 2.0);
  rig.pass(400);
  rig.let_alone(300);
  rig.look();
  CHECK(rig.loop.stalled());
  CHECK(rig.loop.at_rest());
  const double stopped_m = rig.loop.view().height_m;
  CHECK(stopped_m > 0.01);
  CHECK(stopped_m < 0.04);
  rig.pass(200);
  CHECK(rig.loop.view().height_m == stopped_m);
  rig.loop.resume_lift();
  for (int i = 0; i < 40 && !rig.loop.lift_at_rest(); ++i) rig.pass(50);
  CHECK(rig.loop.view().height_m == Approx(0.05).margin(1e-3));
  CHECK_FALSE(rig.loop.stalled());
}

TEST_CASE("Misses are counted, and told with their reason") {
  Rig rig(Drive::Thread);
  rig.pass(3);
  rig.arm.silent_from = rig.arm.cycles.load();
  rig.pass(5);
  CHECK(rig.loop.view().misses == 5);
  CHECK_THAT(rig.loop.view().fault.str(), Catch::Contains("silent"));
  rig.arm.silent_from = 1 << 30;
  rig.pass(1);
  CHECK(rig.loop.view().misses == 0);
  CHECK(rig.loop.view().missed == 5);
}

TEST_CASE("A refused command is told, with the reason of the first") {
  Rig rig(Drive::Thread);
  rig.arm.refuses = true;
  rig.pass(2);
  CHECK(rig.loop.view().refused_commands == 2);
  CHECK_THAT(rig.loop.view().refusal.str(), Catch::Contains("too fast"));
}

TEST_CASE("The end brings a moving arm to rest first") {
  const Drive drive = GENERATE(Drive::InStep, Drive::Thread);
  Rig rig(drive);
  REQUIRE(rig.loop.follow(way()));
  if (drive == Drive::Thread) rig.pass(60);
  for (int i = 0; drive == Drive::InStep && i < 60; ++i) {
    rig.loop.begin_cycle();
    rig.loop.end_cycle();
  }
  CHECK_FALSE(rig.loop.at_rest());
  rig.arm.open_gate();
  rig.loop.finish();
  const auto last = rig.arm.sent.end() - 1;
  CHECK((*last - *(last - 10)).norm() == 0.0);
}

TEST_CASE("A cycle of the arm does not allocate: on a way, with a load, lifting") {
  CountedArm arm(false);
  arm.sent.reserve(1);
  ArmController motion(robot(), geometry(), {}, {});
  const auto cycle = [&] {
    motion.measured(arm.wait_cycle());
    if (const auto command = motion.command()) motion.sent(arm.command(*command));
    (void)motion.view();
  };
  cycle();
  ArmRequest follow{ArmRequest::Kind::Follow, 1, std::make_shared<planner::Trajectory>(way()), 0.0, {}};
  ArmRequest lift{ArmRequest::Kind::StartLift, 2, nullptr, 0.05, LiftController::Role::Lead, 2.0};
  const std::uint64_t before = allocations();
  motion.take(follow);
  for (int i = 0; i < 2500; ++i) cycle();
  motion.take(lift);
  for (int i = 0; i < 1500; ++i) cycle();
  CHECK(allocations() == before);
  CHECK(motion.view().height_m == Approx(0.05).margin(1e-3));
}
