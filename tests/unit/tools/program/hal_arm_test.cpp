// Bring-up of the arm: what it does in each cycle, against the emulated controller and its judgement.
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "hal/guards/guarded_arm.hpp"
#include "sim_hal/emulator/krc/krc_lock_step.hpp"
#include "sim_hal/emulator/krc/plant/krc_light_plant.hpp"
#include "tests/unit/tools/program/obstacle_of_kind.hpp"
#include "tools/bring_up/hal_arm_json.hpp"
#include "tools/bring_up/hal_arm_obstacles.hpp"
#include "tools/bring_up/hal_arm_task.hpp"

namespace colift {
using namespace tools;
namespace {

using tools::ArmTask;
using How = tools::ArmTaskEnd::How;

constexpr double kDeg = 180.0 / std::numbers::pi;
constexpr hal::Endpoint kKrc{0x7F000001, 49152}, kPc{0x7F000001, 49938};

/// An arm behind the emulated controller, in lock step with the test's clock.
struct Stand {
  hal::ManualClock clock;
  sim_hal::MemoryWire wire{clock};
  hal::ArmDynamics dynamics{hal::built_in_robot(), hal::ArmDynamics::Load::Hand};
  std::unique_ptr<sim_hal::LightPlant> plant;
  std::unique_ptr<hal::DatagramLink> end;
  std::unique_ptr<sim_hal::KrcEmulator> krc;
  hal::FriArm* fri = nullptr;
  tools::ControlArm* controls = nullptr;
  std::unique_ptr<hal::Arm> arm;
  hal::GuardConfig guard;
  std::atomic<bool> interrupted{false};
  hal::LatestValue<tools::ArmProgress> progress;

  explicit Stand(sim_hal::KrcConfig krc_config = {}, hal::FriConfig config = {}) {
    sim_hal::LightPlantConfig p;
    p.start_rad << 0.1, 0.7, -0.2, 1.4, 0.1, -0.9, 0.3;
    plant = std::make_unique<sim_hal::LightPlant>(dynamics, p);
    end = wire.end(kKrc);
    REQUIRE(end->open());
    krc = std::make_unique<sim_hal::KrcEmulator>(krc_config, dynamics, *plant, *end);
    REQUIRE(krc->start(clock.now()));
    auto driver =
        std::make_unique<hal::FriArm>(config, wire.end(kPc, sim_hal::lock_step(*krc, clock)), clock);
    fri = driver.get();
    auto controlled = std::make_unique<tools::ControlArm>(std::move(driver), hal::built_in_robot());
    controls = controlled.get();
    arm = std::make_unique<hal::GuardedArm>(std::move(controlled), hal::built_in_robot(), guard);
  }

  tools::ArmTaskEnd run(const ArmTask& task) {
    const tools::ArmTaskHooks hooks{interrupted, progress,
                                    [this] { return why_not(fri->status(), fri->config()); }};
    hal::Arm& used = task.kind == ArmTask::Kind::Watch ? static_cast<hal::Arm&>(*fri) : *arm;
    return run_arm_task(used, hal::built_in_robot(), guard, task, clock, hooks);
  }

  [[nodiscard]] tools::ArmView view() const {
    tools::ProgramMonitor program;
    hal::FriMeasurement m = fri->measurement();
    program.note(m, 0.0);
    ++m.krl.integer[4];
    program.note(m, 1.0);
    return view_of(*fri, program, {}, guard.limit_margin_deg, 1.0);
  }

  [[nodiscard]] std::string broken() const {
    std::string text;
    for (const auto& b : krc->report().broken_rules)
      text += std::string(name(b.rule)) + ": " + b.reason + "\n";
    return text;
  }
  [[nodiscard]] bool left_command_mode() const { return krc->report().state != sim_hal::FriState::Command; }
};

ArmTask hold_for(double s) {
  ArmTask task;
  task.kind = ArmTask::Kind::Hold;
  task.for_s = s;
  return task;
}

ArmTask move(int joint, double deg, double speed_deg_s = 5.0) {
  ArmTask task;
  task.kind = ArmTask::Kind::Move;
  task.joint = joint;
  task.by_rad = deg / kDeg;
  task.speed_rad_s = speed_deg_s / kDeg;
  return task;
}

/// An arm that notes its commands, and interrupts after so many of them, as a person at the keyboard does.
class WatchedArm final : public hal::Arm {
 public:
  WatchedArm(hal::Arm& inner, std::atomic<bool>& flag, int after)
      : inner_(inner), flag_(flag), left_(after) {}
  hal::Result<> configure() override { return inner_.configure(); }
  hal::Result<> activate() override { return inner_.activate(); }
  void deactivate() noexcept override { inner_.deactivate(); }
  hal::DeviceHealth health() const override { return inner_.health(); }
  hal::Result<hal::ArmState> wait_cycle() override { return inner_.wait_cycle(); }
  hal::Result<> command(const hal::ImpedanceCommand& c) override {
    if (--left_ == 0) flag_ = true;
    if (before_) longest_step_ = std::max(longest_step_, (c.q_rad - *before_).cwiseAbs().maxCoeff());
    before_ = c.q_rad;
    if (first_stiffness_ == 0.0) first_stiffness_ = c.stiffness_nm_rad[3];
    last_stiffness_ = c.stiffness_nm_rad[3];
    return inner_.command(c);
  }
  void stop() noexcept override { inner_.stop(); }
  double longest_step_ = 0.0, first_stiffness_ = 0.0, last_stiffness_ = 0.0;

 private:
  hal::Arm& inner_;
  std::atomic<bool>& flag_;
  int left_;
  std::optional<hal::JointVector> before_;
};

}  // namespace

TEST_CASE("watching asks for nothing and moves nothing", "[hal][arm]") {
  Stand s;
  ArmTask watch;
  watch.for_s = 1.0;
  const auto end = s.run(watch);
  INFO(end.reason);
  CHECK(end.how == How::Done);
  CHECK(end.cycles > 400);
  CHECK_FALSE(end.commanded);
  CHECK(s.krc->report().command_cycles == 0);
  CHECK(s.broken().empty());
  const auto found = obstacles(s.view(), hal::built_in_robot());
  INFO(obstacles_text(found));
  CHECK(std::none_of(found.begin(), found.end(), [](const auto& o) { return o.refuses; }));
}

TEST_CASE("holding gets command mode, stays at the measured pose, and leaves", "[hal][arm]") {
  Stand s;
  const auto end = s.run(hold_for(2.0));
  INFO(end.reason);
  REQUIRE(end.how == How::Done);
  CHECK(end.commanded_s == Approx(2.0).margin(0.01));
  CHECK(s.krc->report().command_cycles > 900);
  CHECK((end.end_rad - end.start_rad).cwiseAbs().maxCoeff() < 0.002);
  CHECK(s.left_command_mode());
  INFO(s.broken());
  CHECK(s.broken().empty());
}

TEST_CASE("a joint moves by the angle, no faster than asked, the others stay", "[hal][arm]") {
  Stand s;
  const auto end = s.run(move(3, -10.0, 5.0));
  INFO(end.reason);
  REQUIRE(end.how == How::Done);
  const hal::JointVector by = end.end_rad - end.start_rad;
  CHECK(kDeg * by[3] == Approx(-10.0).margin(0.2));
  for (const int other : {0, 1, 2, 4, 5, 6}) CHECK(std::abs(kDeg * by[other]) < 0.2);
  CHECK(end.commanded_s > 2.0);  // 10 deg with 5 deg/s, and time to speed up and arrive
  CHECK(end.commanded_s < 5.0);
  CHECK(s.left_command_mode());
  INFO(s.broken());
  CHECK(s.broken().empty());
}

TEST_CASE("the measured pose is held in every control strategy", "[hal][arm]") {
  const std::string control = GENERATE("position", "cartesian_impedance");
  Stand s;
  s.controls->use(control);
  const auto end = s.run(hold_for(2.0));
  INFO(control << " " << end.reason);
  REQUIRE(end.how == How::Done);
  CHECK((end.end_rad - end.start_rad).cwiseAbs().maxCoeff() < 0.002);
  CHECK(s.fri->measurement().control ==
        (control == "position" ? hal::FriControl::Position : hal::FriControl::CartesianImpedance));
  INFO(s.broken());
  CHECK(s.broken().empty());
}

TEST_CASE("a joint moves in position control, and the tool as its joints say in Cartesian impedance",
          "[hal][arm]") {
  const std::string control = GENERATE("position", "cartesian_impedance");
  Stand s;
  s.controls->use(control);
  const auto end = s.run(move(3, -8.0, 5.0));
  INFO(control << " " << end.reason);
  REQUIRE(end.how == How::Done);
  const hal::Vec3 asked = s.dynamics.flange(end.goal_rad).translation();
  const hal::Vec3 reached = s.dynamics.flange(end.end_rad).translation();
  CHECK((asked - s.dynamics.flange(end.start_rad).translation()).norm() > 0.02);
  CHECK((asked - reached).norm() < 0.003);
  if (control == "position") CHECK(kDeg * (end.end_rad - end.start_rad)[3] == Approx(-8.0).margin(0.1));
  INFO(s.broken());
  CHECK(s.broken().empty());
}

TEST_CASE("a controller of 100 ms is commanded through the guard as well", "[hal][arm]") {
  sim_hal::KrcConfig krc;
  const int ms = GENERATE(50, 100);
  krc.cycle = std::chrono::milliseconds(ms);
  hal::FriConfig config;
  config.cycle_ms = ms;
  Stand s(krc, config);
  const auto end = s.run(move(3, -10.0, 5.0));
  INFO(ms << " ms: " << end.reason);
  REQUIRE(end.how == How::Done);
  CHECK(kDeg * (end.end_rad - end.start_rad)[3] == Approx(-10.0).margin(0.2));
  INFO(s.broken());
  CHECK(s.broken().empty());
}

TEST_CASE("a switch commands each strategy in turn, and tells how each was reached", "[hal][arm]") {
  Stand s;
  int asked = 0;
  const auto end = tools::run_switch(
      *s.arm, *s.controls, {"joint_impedance", "cartesian_impedance", "position", "joint_impedance"}, 0.5,
      s.clock, s.interrupted, [&](bool asks) { asked += asks; }, {});
  INFO(end.reason << "\n" << tools::describe(end));
  REQUIRE(end.reason.empty());
  CHECK(asked == 4);
  REQUIRE(end.steps.size() == 4);
  for (const auto& step : end.steps) {
    CHECK(step.reached);
    CHECK(step.held_s == Approx(0.5).margin(0.01));
    CHECK(step.took_s < 3.0);
    CHECK(step.moved_rad < 0.003);
  }
  CHECK(s.left_command_mode());
  CHECK(s.broken().empty());
}

TEST_CASE("a switch that is refused, interrupted or cut off ends at rest outside of command mode",
          "[hal][arm]") {
  SECTION("refused") {
    sim_hal::KrcConfig krc;
    krc.faults.push_back(sim_hal::parse_krc_fault("3:quality=bad:60").value());
    hal::FriConfig config;
    config.ready_s = 8.0;
    Stand s(krc, config);
    const auto end = tools::run_switch(
        *s.arm, *s.controls, {"joint_impedance", "position", "joint_impedance"}, 4.0, s.clock, s.interrupted,
        [](bool) {}, [&] { return why_not(s.fri->status(), s.fri->config()); });
    INFO(end.reason);
    REQUIRE(end.steps.size() == 2);
    CHECK(end.steps[0].reached);
    CHECK_FALSE(end.steps[1].reached);
    CHECK(end.reason.find("position: ") == 0);
    CHECK(tools::describe(end).find("position: not reached") != std::string::npos);
    CHECK(s.left_command_mode());
  }
  SECTION("interrupted") {
    Stand s;
    const auto end = tools::run_switch(*s.arm, *s.controls, {"joint_impedance", "position"}, 1.0, s.clock,
                                       s.interrupted, [&](bool asks) { s.interrupted = !asks; }, {});
    CHECK(end.interrupted);
    CHECK(end.steps.size() == 1);
    CHECK(s.left_command_mode());
    CHECK(s.broken().empty());
  }
  SECTION("an emergency stop") {
    sim_hal::KrcConfig krc;
    krc.faults.push_back(sim_hal::parse_krc_fault("5:emergency-stop:60").value());
    Stand s(krc);
    const auto end = tools::run_switch(
        *s.arm, *s.controls, {"joint_impedance", "position"}, 20.0, s.clock, s.interrupted, [](bool) {},
        [&] { return why_not(s.fri->status(), s.fri->config()); });
    CHECK(end.reason.find("the drives are off") != std::string::npos);
    CHECK(end.steps.size() == 1);
    CHECK(s.left_command_mode());
  }
}

TEST_CASE("a motion beyond a limit is refused before command mode is asked for", "[hal][arm]") {
  Stand s;
  const auto end = s.run(move(5, -80.0));  // A6 stands at -52 deg, its limit is -120
  CHECK(end.how == How::BadRequest);
  CHECK(end.reason.find("A6") != std::string::npos);
  CHECK(end.reason.find("-67.4") != std::string::npos);  // what is left this way
  CHECK(s.krc->report().command_cycles == 0);
}

TEST_CASE("limits count the guard's margin, and leave the way back from beyond it", "[hal][arm]") {
  const hal::GuardConfig guard;
  const auto& model = hal::built_in_robot();
  CHECK(beyond_limits(model, guard, 1, 118.0 / kDeg, 0.9 / kDeg).empty());
  CHECK_FALSE(beyond_limits(model, guard, 1, 118.0 / kDeg, 1.5 / kDeg).empty());
  CHECK(beyond_limits(model, guard, 1, 119.8 / kDeg, -5.0 / kDeg).empty());
  CHECK_FALSE(beyond_limits(model, guard, 1, 119.8 / kDeg, 0.1 / kDeg).empty());
}

TEST_CASE("interrupted in the middle of a motion it comes to rest on the way and leaves", "[hal][arm]") {
  Stand s;
  WatchedArm arm(*s.arm, s.interrupted, 600);
  const tools::ArmTaskHooks hooks{s.interrupted, s.progress, {}};
  const auto task = move(0, 20.0, 10.0);
  const auto end = run_arm_task(arm, hal::built_in_robot(), s.guard, task, s.clock, hooks);
  CHECK(end.how == How::Interrupted);
  const double moved = kDeg * (end.goal_rad[0] - end.start_rad[0]);
  CHECK(moved > 1.0);
  CHECK(moved < 19.0);
  CHECK(arm.longest_step_ < 1.1 * task.speed_rad_s * 0.002);
  CHECK(s.left_command_mode());
  INFO(s.broken());
  CHECK(s.broken().empty());
}

TEST_CASE("the stiffness that was asked for arrives at the arm", "[hal][arm]") {
  Stand s;
  ArmTask task = hold_for(1.5);
  task.stiffness_nm_rad = 200.0;
  WatchedArm arm(*s.arm, s.interrupted, 1'000'000);
  const auto end =
      run_arm_task(arm, hal::built_in_robot(), s.guard, task, s.clock, {s.interrupted, s.progress, {}});
  INFO(end.reason);
  CHECK(end.how == How::Done);
  CHECK(arm.first_stiffness_ == Approx(1000.0).margin(10.0));  // as the driver starts; then on a ramp
  CHECK(arm.last_stiffness_ == Approx(200.0));
  CHECK(end.drift_rad.maxCoeff() < 0.05);
  INFO(s.broken());
  CHECK(s.broken().empty());
}

TEST_CASE("a controller without its program refuses in words, and nothing moves", "[hal][arm]") {
  sim_hal::KrcConfig krc;
  krc.script = "tum";  // the client expects colift
  hal::FriConfig config;
  config.ready_s = 5.0;
  Stand s(krc, config);
  const auto end = s.run(hold_for(1.0));
  CHECK(end.how == How::Refused);
  INFO(end.reason);
  CHECK_FALSE(end.reason.empty());
  CHECK_FALSE(end.commanded);
  CHECK(s.krc->report().command_cycles == 0);
  const auto found = obstacles(s.view(), hal::built_in_robot());
  REQUIRE(test::obstacle(found, "program"));
  CHECK(test::obstacle(found, "program")->refuses);
  CHECK(test::obstacle(found, "program")->next.find("colift.src") != std::string::npos);
}

TEST_CASE("an emergency stop while holding ends it with the reason", "[hal][arm]") {
  sim_hal::KrcConfig krc;
  auto fault = sim_hal::parse_krc_fault("6:emergency-stop:2");
  if (!fault) FAIL(fault.error().text());
  krc.faults.push_back(*fault);
  Stand s(krc);
  const auto end = s.run(hold_for(20.0));
  CHECK(end.how == How::Lost);
  INFO(end.reason);
  CHECK(end.reason.find("the drives are off") != std::string::npos);
  CHECK(end.commanded);
  CHECK(end.commanded_s < 19.0);

  // who looks afterwards is told that the program halted, and not that nothing is in the way
  ArmTask watch;
  watch.for_s = 1.2;
  tools::ProgramMonitor program;
  program.note(s.fri->measurement(), 0.0);
  CHECK(s.run(watch).how == How::Done);
  program.note(s.fri->measurement(), watch.for_s);
  CHECK_FALSE(program.heart_beats());
  const auto found =
      obstacles(view_of(*s.fri, program, {}, s.guard.limit_margin_deg, watch.for_s), hal::built_in_robot());
  const auto* halted = test::obstacle(found, "program");
  REQUIRE(halted);
  CHECK(halted->refuses);
  CHECK(halted->next.find("emergency stop") != std::string::npos);
}

TEST_CASE("nobody on the wire is refused within the deadline", "[hal][arm]") {
  hal::ManualClock clock;
  sim_hal::MemoryWire wire(clock);
  hal::FriConfig config;
  config.first_s = 0.5;
  hal::FriArm fri(config,
                  wire.end(kPc,
                           [&](hal::Timestamp until) {
                             clock.advance(until - clock.now());
                             return true;
                           }),
                  clock);
  std::atomic<bool> interrupted{false};
  hal::LatestValue<tools::ArmProgress> progress;
  const auto end =
      run_arm_task(fri, hal::built_in_robot(), {}, hold_for(1.0), clock, {interrupted, progress, {}});
  CHECK(end.how == How::Refused);
  CHECK(end.reason.find("nothing usable comes") != std::string::npos);
  CHECK(hal::seconds(clock.now()) < 1.0);
  tools::ArmView view = view_of(fri, {}, {}, 1.0, 0.5);
  const auto found = obstacles(view, hal::built_in_robot());
  REQUIRE(test::obstacle(found, "silence"));
  CHECK(arm_screen(view, hal::built_in_robot()).find("would be refused now") != std::string::npos);
}

}  // namespace colift
