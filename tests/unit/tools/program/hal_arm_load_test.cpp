// colift hal arm load over the wire: what hangs on the flange, against the load data of the emulated
// controller.
#include <catch2/catch.hpp>

#include "hal/guards/guarded_arm.hpp"
#include "sim_hal/emulator/krc/krc_lock_step.hpp"
#include "sim_hal/emulator/krc/plant/krc_light_plant.hpp"
#include "tools/bring_up/control/control_arm.hpp"
#include "tools/bring_up/hal_arm_obstacles.hpp"
#include "tools/bring_up/hal_arm_task.hpp"

namespace colift {
using namespace tools;
namespace {

using How = ArmTaskEnd::How;

constexpr hal::Endpoint kKrc{0x7F000001, 49152}, kPc{0x7F000001, 49938};

struct Felt {
  ArmTaskEnd end;
  std::string broken;
  std::vector<Obstacle> found;
};

/// The verb in lock step, at an arm with these faults.
Felt feel(const std::vector<std::string>& faults, double a7_rad = 0.3,
          const std::string& control = "position") {
  hal::ManualClock clock;
  sim_hal::MemoryWire wire{clock};
  const hal::ArmDynamics dynamics{hal::built_in_robot(), hal::ArmDynamics::Load::Hand};
  sim_hal::LightPlantConfig p;
  p.start_rad << 0.1, 0.7, -0.2, 1.4, 0.1, -0.9, a7_rad;
  sim_hal::LightPlant plant(dynamics, p);
  auto end = wire.end(kKrc);
  REQUIRE(end->open());
  sim_hal::KrcConfig config;
  for (const auto& fault : faults) config.faults.push_back(sim_hal::parse_krc_fault(fault).value());
  sim_hal::KrcEmulator krc(config, dynamics, plant, *end);
  REQUIRE(krc.start(clock.now()));
  const hal::GuardConfig guard;
  auto driver =
      std::make_unique<hal::FriArm>(hal::FriConfig{}, wire.end(kPc, sim_hal::lock_step(krc, clock)), clock);
  hal::FriArm& fri = *driver;
  auto controlled = std::make_unique<ControlArm>(std::move(driver), hal::built_in_robot());
  controlled->use(control);
  hal::GuardedArm arm(std::move(controlled), hal::built_in_robot(), guard);
  ArmTask task;
  task.control = control;
  task.kind = ArmTask::Kind::Load;
  task.speed_rad_s = 10.0 / 57.2958;
  const std::atomic<bool> interrupted{false};
  hal::LatestValue<ArmProgress> progress;
  Felt felt;
  felt.end = run_arm_task(arm, hal::built_in_robot(), guard, task, clock,
                          {interrupted, progress, [&] { return why_not(fri.status(), fri.config()); }});
  for (const auto& b : krc.report().broken_rules) felt.broken += b.reason + "\n";
  CHECK(krc.report().state != sim_hal::FriState::Command);
  felt.found = obstacles(view_of(fri, {}, {}, guard.limit_margin_deg, 1.0), hal::built_in_robot());
  return felt;
}

bool told(const Felt& felt, const std::string& kind) {
  return std::any_of(felt.found.begin(), felt.found.end(), [&](const auto& o) { return o.kind == kind; });
}

}  // namespace

TEST_CASE("load data that fit are said to fit, and the arm comes back to where it stood", "[hal][arm]") {
  const Felt felt = feel({});
  INFO(felt.end.reason << felt.broken);
  REQUIRE(felt.end.how == How::Done);
  CHECK(felt.broken.empty());
  REQUIRE(felt.end.load);
  CHECK(std::abs(felt.end.load->more.mass_kg) < 0.02);
  CHECK((felt.end.end_rad - felt.end.start_rad).cwiseAbs().maxCoeff() < 0.01);
  CHECK_FALSE(told(felt, "unexplained-load"));
}

TEST_CASE("0.2 kg that the load data do not know are found and named", "[hal][arm]") {
  // before any impedance mode, or in it where the KRL program has nothing else
  const std::string control = GENERATE("position", "joint_impedance");
  for (const double kg : {0.2, -0.2}) {
    const Felt felt = feel({"0:load=" + std::to_string(kg) + ":1000000"}, 0.3, control);
    INFO(felt.end.reason << felt.broken);
    REQUIRE(felt.end.how == How::WrongLoad);
    CHECK(exit_code(felt.end.how) == 1);
    REQUIRE(felt.end.load);
    CHECK(felt.end.load->more.mass_kg == Approx(kg).margin(0.03));
    CHECK(felt.end.load->more.moment_kgm.norm() < 0.005);
    ArmTask task;
    task.kind = ArmTask::Kind::Load;
    const std::string text = task_summary(task, felt.end);
    INFO(text);
    CHECK(text.find("load data are wrong") != std::string::npos);
    CHECK(text.find("tool_no in colift.src") != std::string::npos);
    // a remark for springs alone: in position control nothing yields to it
    CHECK(told(felt, "unexplained-load") == (control == "joint_impedance"));
  }
}

TEST_CASE("a torque sensor with an offset is no load, and is named as what it is", "[hal][arm]") {
  const Felt felt = feel({"0:torque-offset=4@3:1000000"});
  INFO(felt.end.reason);
  REQUIRE(felt.end.how == How::WrongLoad);
  REQUIRE(felt.end.load);
  CHECK(felt.end.load->unexplained());
  CHECK(felt.end.load->residual_joint == 2);
}

TEST_CASE("near a limit the poses lie on this side of it, beyond it nothing moves", "[hal][arm]") {
  const double limit = hal::built_in_robot().upper_rad()[6];
  const Felt near = feel({}, limit - 0.15);
  INFO(near.end.reason);
  CHECK(near.end.how == How::Done);
  const Felt at = feel({}, limit - 0.001);
  CHECK(at.end.how == How::BadRequest);
  CHECK_FALSE(at.end.commanded);
}

}  // namespace colift
