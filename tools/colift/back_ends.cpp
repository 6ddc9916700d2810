#include "tools/colift/back_ends.hpp"

#include <cmath>

#include "hal/barrett/make_barrett_hand.hpp"
#include "hal/barrett/puck_codec.hpp"
#include "hal/fri/fri_arm.hpp"
#include "hal/guarded_arm.hpp"
#include "hal/guarded_camera.hpp"
#include "hal/guarded_hand.hpp"
#include "hal/kinect/kinect_camera.hpp"
#include "hal/os/make_can_bus.hpp"
#include "hal/os/udp_link.hpp"
#include "sim_hal/emulator/camera_server.hpp"
#include "sim_hal/emulator/hand_gateway.hpp"
#include "sim_hal/emulator/hand_server.hpp"
#include "sim_hal/emulator/krc_server.hpp"
#include "sim_hal/emulator/mujoco/camera_world_eye.hpp"
#include "sim_hal/emulator/mujoco/hand_world_plant.hpp"
#include "sim_hal/emulator/mujoco/krc_world_plant.hpp"
#include "perception/calibration/calibration_file.hpp"
#include "sim_hal/mujoco/sim_devices.hpp"
#include "sim_hal/mujoco/sim_infrared.hpp"
#include "sim_hal/mujoco/sim_world.hpp"
#include "sim_hal/scenario/scenario.hpp"
#include "tools/colift/emulate_hand.hpp"
#include "tools/colift/rig_truth.hpp"
#include "tools/colift/robot_file.hpp"

namespace colift::tools {
namespace {

using World = std::shared_ptr<sim_hal::SimWorld>;

hal::Result<sim_hal::Scenario> read_scenario(const std::optional<std::filesystem::path>& file) {
  if (file && *file == kClearedFloor)
    return sim_hal::parse_scenario(
        "schema: colift.scenario/1\n"
        "object: {kind: box, size: [0.3, 0.3, 0.3], mass: 2.0, pose: {xyz: [-1.6, 1.6, 0.0]}}\n"
        "camera: {xyz: [2.1, -0.7, 1.3], look_at: [0.65, 0.0, 0.45]}\n"
        "partner: {kind: none}\n",
        "cleared floor");
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

/// What the scenario does to the hand, in terms of its pucks and bus.
hal::Result<std::vector<sim_hal::HandFault>> hand_faults(const sim_hal::Scenario& scenario) {
  std::vector<sim_hal::HandFault> faults;
  for (const sim_hal::DeviceFaultEvent& event : scenario.faults) {
    if (event.device != "hand") continue;
    auto fault = sim_hal::hand_fault(event);
    if (!fault) return tl::unexpected(fault.error());
    faults.push_back(std::move(*fault));
  }
  return faults;
}

/// The pucks at the far end of the hand's bus, asleep as after power-on: behind a gateway as `barrett.can` names
/// it, or on an interface of this machine.
hal::Result<std::shared_ptr<sim_hal::HandServer>> start_pucks(const RobotFile& file,
                                                              sim_hal::SimWorld& world, std::uint64_t seed) {
  std::unique_ptr<hal::CanBus> bus;
  if (file.barrett.can.starts_with("socketcan:")) {
    auto made = hal::make_can_bus(file.barrett.can);
    if (!made) return tl::unexpected(made.error());
    bus = std::move(*made);
  } else {
    const auto gateway = gateway_config(file.barrett.can);
    if (!gateway) return tl::unexpected(gateway.error());
    bus = std::make_unique<sim_hal::HandGateway>(*gateway);
  }
  sim_hal::HandEmulatorConfig config;
  config.judges_pace = false;
  config.seed = seed;
  auto server =
      std::make_shared<sim_hal::HandServer>(config, std::make_unique<sim_hal::HandWorldPlant>(world),
                                            std::move(bus));
  if (auto started = server->start(); !started) return tl::unexpected(started.error());
  return server;
}

/// A Kinect at the far end of libfreenect's functions, in front of the world.
hal::Result<std::shared_ptr<sim_hal::CameraServer>> start_kinect(const sim_hal::SimWorld& world,
                                                                 std::uint64_t seed) {
  sim_hal::CameraServerConfig config;
  config.seed = seed;
  auto server = std::make_shared<sim_hal::CameraServer>(config, std::make_unique<sim_hal::CameraWorldEye>(world));
  if (auto started = server->start(); !started) return tl::unexpected(started.error());
  return server;
}

/// What the scenario does to the camera, in terms of the device.
hal::Result<std::vector<sim_hal::CameraFault>> camera_faults(const sim_hal::Scenario& scenario) {
  std::vector<sim_hal::CameraFault> faults;
  for (const sim_hal::DeviceFaultEvent& event : scenario.faults) {
    if (event.device != "camera") continue;
    auto fault = sim_hal::camera_fault(event);
    if (!fault) return tl::unexpected(fault.error());
    faults.push_back(std::move(*fault));
  }
  return faults;
}

/// The camera that the file names, in the rig.
hal::Result<> add_camera(const RobotFile& file, const sim_hal::Scenario& scenario, sim_hal::SimWorld& world,
                         std::uint64_t seed, const control::Config& config, Rig& rig) {
  if (file.camera == "simulated") {
    rig.robot.camera = sim_hal::make_sim_camera(world);
    rig.infrared = sim_hal::make_sim_infrared(world, {});
    return {};
  }
  hal::KinectConfig kinect = file.kinect;
  if (file.emulator != "never") {
    auto faults = camera_faults(scenario);
    if (!faults) return tl::unexpected(faults.error());
    auto server = start_kinect(world, seed);
    if (!server) return tl::unexpected(server.error());
    kinect.source = "emulated:" + (*server)->address();
    kinect.motor = true;
    rig.far_ends.push_back(*server);
    rig.begin = [before = std::move(rig.begin), server = *server, faults = std::move(*faults)] {
      if (before) before();
      for (const sim_hal::CameraFault& fault : faults) server->inject(fault);
    };
  }
  hal::CameraGuardConfig guard = config.guard_camera;
  if (scenario.camera.noise == "none") guard.stuck_s = 0.0;  // an ideal camera shows a scene at rest alike
  const hal::Vec3 up_C = rig.X_WC.linear().transpose() * hal::Vec3::UnitZ();
  rig.robot.camera =
      std::make_unique<hal::GuardedCamera>(std::make_unique<hal::KinectCamera>(kinect, *rig.robot.clock), guard,
                                           *rig.robot.clock, up_C);
  return {};
}

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
                        "a run whose devices are all real cannot be opened yet: its world's time would be moved "
                        "by nobody; expected emulator: always (colift hal needs none)");
  // the devices of one world: a simulated arm steps it, a wire's far end lets it run
  if (file->arm == "simulated" && file->hand == "barrett")
    return hal::failure(hal::ErrorCode::BadConfig, robot->string(),
                        "hand: barrett lives in real time, and arm: simulated does not; expected arm: fri");
  if (file->arm == "simulated" && file->camera == "kinect")
    return hal::failure(hal::ErrorCode::BadConfig, robot->string(),
                        "camera: kinect lives in real time, and arm: simulated does not; expected arm: fri");
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
      auto faults = hand_faults(*read);
      if (!faults) return tl::unexpected(faults.error());
      auto pucks = start_pucks(*file, **world, seed);
      if (!pucks) return tl::unexpected(pucks.error());
      rig.far_ends.push_back(*pucks);
      // the scenario's times count from its begin, and waking and initialising take a while before
      rig.begin = [before = std::move(rig.begin), pucks = *pucks, faults = std::move(*faults)] {
        if (before) before();
        for (const sim_hal::HandFault& fault : faults) pucks->inject(fault);
      };
    }
    const auto filters = hal::barrett::hand_filters();
    auto bus = hal::make_can_bus(file->barrett.can, {filters.begin(), filters.end()});
    if (!bus) return tl::unexpected(bus.error());
    rig.robot.hand = std::make_unique<hal::GuardedHand>(
        hal::make_barrett_hand(std::move(*bus), file->barrett), config.guard_hand);
  }
  rig.X_WC = rig.true_X_WC = sim_hal::camera_pose(read->camera);
  if (!file->calibration.empty()) {
    const auto calibration = perception::load_calibration(file->calibration, config.calibration);
    if (!calibration) return tl::unexpected(calibration.error());
    rig.X_WC = calibration->X_BC();
  }
  if (auto done = add_camera(*file, *read, **world, seed, config, rig); !done) return tl::unexpected(done.error());
  rig.home_rad = (*world)->arm_state().q_rad;
  rig.truth = truth_of(*world, rig.model);
  return rig;
}

}  // namespace colift::tools
