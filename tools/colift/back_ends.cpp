#include "tools/colift/back_ends.hpp"

#include <cmath>

#include "hal/barrett/barrett_hand.hpp"
#include "hal/barrett/hand_thread.hpp"
#include "hal/barrett/puck_codec.hpp"
#include "hal/fri/fri_arm.hpp"
#include "hal/guarded_arm.hpp"
#include "hal/guarded_hand.hpp"
#include "hal/os/make_can_bus.hpp"
#include "hal/os/udp_link.hpp"
#include "sim_hal/emulator/hand_gateway.hpp"
#include "sim_hal/emulator/hand_server.hpp"
#include "sim_hal/emulator/krc_server.hpp"
#include "sim_hal/emulator/mujoco/hand_world_plant.hpp"
#include "sim_hal/emulator/mujoco/krc_world_plant.hpp"
#include "sim_hal/mujoco/sim_devices.hpp"
#include "sim_hal/mujoco/sim_world.hpp"
#include "sim_hal/scenario/scenario.hpp"
#include "tools/colift/emulate_hand.hpp"
#include "tools/colift/rig_truth.hpp"
#include "tools/colift/robot_file.hpp"

namespace colift::tools {
namespace {

using World = std::shared_ptr<sim_hal::SimWorld>;

hal::Result<sim_hal::Scenario> read_scenario(const std::optional<std::filesystem::path>& file) {
  if (file) return sim_hal::load_scenario(*file);
  return sim_hal::built_in_scenario();
}

hal::Result<std::shared_ptr<const hal::RobotModel>> read_model(const std::string& file) {
  if (file.empty()) return std::make_shared<hal::RobotModel>(hal::built_in_robot());
  auto model = hal::load_robot(file);
  if (!model) return tl::unexpected(model.error());
  return std::make_shared<hal::RobotModel>(std::move(*model));
}

hal::Result<World> make_world(const RobotFile& file, const sim_hal::Scenario& scenario,
                              const hal::RobotModel& model, std::uint64_t seed) {
  sim_hal::SimConfig sim;
  const double period_ms = file.arm == "simulated" ? file.arm_period_ms : file.fri.cycle_ms;
  sim.arm_period = std::chrono::milliseconds(std::lround(period_ms));
  auto world = sim_hal::SimWorld::make(scenario, model, seed, sim);
  if (!world) return tl::unexpected(world.error());
  return World(std::move(*world));
}

/// The controller at the far end of the arm's wire, on the same world as the other simulated devices.
hal::Result<std::shared_ptr<sim_hal::KrcServer>> start_krc(const RobotFile& file,
                                                           const sim_hal::Scenario& scenario,
                                                           const hal::RobotModel& model,
                                                           sim_hal::SimWorld& world, std::uint64_t seed) {
  sim_hal::KrcServerConfig config;
  config.krc.to = {0x7f000001, static_cast<std::uint16_t>(file.fri.port)};
  config.krc.cycle = world.config().arm_period;
  config.krc.script = file.fri.script;
  config.krc.seed = seed;
  for (const sim_hal::DeviceFaultEvent& event : scenario.faults) {
    if (event.device != "arm") continue;
    auto fault = sim_hal::krc_fault(event);
    if (!fault) return tl::unexpected(fault.error());
    config.krc.faults.push_back(*fault);
  }
  const hal::ArmDynamics dynamics(model, hal::ArmDynamics::Load::Hand);
  auto server = std::make_shared<sim_hal::KrcServer>(
      config, dynamics, std::make_unique<sim_hal::KrcWorldPlant>(world, dynamics));
  world.start_at(hal::SteadyClock().now());
  if (auto started = server->start(); !started) return tl::unexpected(started.error());
  return server;
}

/// The pucks at the far end of the hand's bus, woken already, behind a gateway as `barrett.can` names it.
hal::Result<std::shared_ptr<sim_hal::HandServer>> start_pucks(const RobotFile& file,
                                                              const sim_hal::Scenario& scenario,
                                                              sim_hal::SimWorld& world, std::uint64_t seed) {
  const auto gateway = gateway_config(file.barrett.can);
  if (!gateway) return tl::unexpected(gateway.error());
  sim_hal::HandEmulatorConfig config;
  config.puck.awake = true;
  config.judges_pace = false;
  config.seed = seed;
  for (const sim_hal::DeviceFaultEvent& event : scenario.faults) {
    if (event.device != "hand") continue;
    auto fault = sim_hal::hand_fault(event);
    if (!fault) return tl::unexpected(fault.error());
    config.faults.push_back(*fault);
  }
  auto server =
      std::make_shared<sim_hal::HandServer>(config, std::make_unique<sim_hal::HandWorldPlant>(world),
                                            std::make_unique<sim_hal::HandGateway>(*gateway));
  if (auto started = server->start(); !started) return tl::unexpected(started.error());
  return server;
}

/// The hand's driver in a thread of its own, with its bus.
class OwnedBarrettHand final : public hal::Hand {
 public:
  OwnedBarrettHand(std::unique_ptr<hal::CanBus> bus, const hal::BarrettHandConfig& config)
      : bus_(std::move(bus)), thread_(std::make_unique<hal::BarrettHand>(*bus_, config, clock_)) {}
  hal::Result<> configure() override { return thread_.configure(); }
  hal::Result<> activate() override { return thread_.activate(); }
  void deactivate() noexcept override { thread_.deactivate(); }
  [[nodiscard]] hal::DeviceHealth health() const override { return thread_.health(); }
  hal::Result<hal::HandState> state() override { return thread_.state(); }
  hal::Result<> preshape(double spread_rad) override { return thread_.preshape(spread_rad); }
  hal::Result<> close(double torque_nm) override { return thread_.close(torque_nm); }
  hal::Result<> release() override { return thread_.release(); }
  void stop() noexcept override { thread_.stop(); }

 private:
  hal::SteadyClock clock_;
  std::unique_ptr<hal::CanBus> bus_;
  hal::HandThread thread_;
};

ArmLink link_of(const hal::FriArm& arm, const sim_hal::KrcServer* krc) {
  ArmLink link;
  const hal::FriStatus status = arm.status();
  const hal::AnswerTimes& times = arm.answer_times();
  link.cycles = status.received;
  link.answered = status.answered;
  link.lost = status.lost;
  link.answer_us = {times.percentile_us(0.5), times.percentile_us(0.99), times.percentile_us(0.999),
                    times.worst_us()};
  if (krc == nullptr) return link;
  const sim_hal::KrcReport report = krc->report();
  const sim_hal::KrcServerTiming timing = krc->timing();
  link.controller =
      ArmLink::Controller{report.sent, report.answered,     report.missed, report.most_missed_in_a_row,
                          timing.late, timing.worst_late_ms};
  for (const auto& broken : report.broken_rules) link.controller->broken_rules.push_back(broken.because);
  return link;
}

}  // namespace

hal::Result<RunTask> read_task(const std::optional<std::filesystem::path>& scenario) {
  const auto read = read_scenario(scenario);
  if (!read) return tl::unexpected(read.error());
  return RunTask{read->name, read->task.height, read->task.hold_s};
}

hal::Result<Rig> open_rig(const std::optional<std::filesystem::path>& robot,
                          const std::optional<std::filesystem::path>& scenario, std::uint64_t seed,
                          const control::Config& config) {
  const auto file = read_robot_file(robot);
  if (!file) return tl::unexpected(file.error());
  // nobody would move the simulated world's time
  if (file->arm == "fri" && file->emulator == "never")
    return hal::failure(hal::ErrorCode::BadConfig, robot->string(),
                        "camera: simulated stands in a world that only an emulated arm moves, and there is no "
                        "driver of a real camera yet; expected emulator: always (colift hal needs none)");
  // the devices of one world: a simulated arm steps it, a wire's far end lets it run
  if (file->arm == "simulated" && file->hand == "barrett")
    return hal::failure(hal::ErrorCode::BadConfig, robot->string(),
                        "hand: barrett lives in real time, and arm: simulated does not; expected arm: fri");
  Rig rig;
  rig.name = robot ? robot->filename().string() : "simulated rig";
  auto model = read_model(file->model);
  if (!model) return tl::unexpected(model.error());
  rig.model = std::move(*model);
  const auto read = read_scenario(scenario);
  if (!read) return tl::unexpected(read.error());

  auto world = make_world(*file, *read, *rig.model, seed);
  if (!world) return tl::unexpected(world.error());
  rig.world = *world;
  std::unique_ptr<hal::Arm> arm;
  if (file->arm == "simulated") {
    arm = sim_hal::make_sim_arm(**world);
    rig.robot.clock = sim_hal::make_sim_clock(**world);
  } else {
    rig.drive = control::Drive::Thread;
    rig.robot.clock = std::make_unique<hal::SteadyClock>();
    const auto address = hal::parse_endpoint(file->fri.address + ":" + std::to_string(file->fri.port));
    if (!address) return tl::unexpected(address.error());
    auto fri = std::make_unique<hal::FriArm>(file->fri, hal::make_udp_link(*address), *rig.robot.clock);
    std::shared_ptr<sim_hal::KrcServer> krc;
    if (file->emulator != "never") {
      auto started = start_krc(*file, *read, *rig.model, **world, seed);
      if (!started) return tl::unexpected(started.error());
      krc = std::move(*started);
    }
    rig.arm_link = [driver = fri.get(), krc] { return link_of(*driver, krc.get()); };
    rig.far_ends.push_back(krc);
    rig.begin = [world = *world] { world->begin_scenario(); };
    arm = std::move(fri);
  }
  rig.robot.arm = std::make_unique<hal::GuardedArm>(std::move(arm), *rig.model, config.guard_arm);
  if (file->hand == "simulated") {
    rig.robot.hand = std::make_unique<hal::GuardedHand>(sim_hal::make_sim_hand(**world), config.guard_hand);
  } else {
    if (file->emulator != "never") {
      auto pucks = start_pucks(*file, *read, **world, seed);
      if (!pucks) return tl::unexpected(pucks.error());
      rig.far_ends.push_back(*pucks);
    }
    const auto filters = hal::barrett::hand_filters();
    auto bus = hal::make_can_bus(file->barrett.can, {filters.begin(), filters.end()});
    if (!bus) return tl::unexpected(bus.error());
    rig.robot.hand = std::make_unique<hal::GuardedHand>(
        std::make_unique<OwnedBarrettHand>(std::move(*bus), file->barrett), config.guard_hand);
  }
  rig.robot.camera = sim_hal::make_sim_camera(**world);
  rig.X_WC = sim_hal::camera_pose(read->camera);
  rig.home_rad = (*world)->arm_state().q_rad;
  rig.truth = truth_of(*world, rig.model);
  return rig;
}

}  // namespace colift::tools
