#include "tools/rig/emulated_rig.hpp"

#include <fmt/format.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <cstddef>

#include "hal/os/make_can_bus.hpp"
#include "hal/robot_model/dynamics.hpp"
#include "hal/types/camera_name.hpp"
#include "sim_hal/emulator/hand/hand_gateway.hpp"
#include "sim_hal/emulator/mujoco/camera_world_source.hpp"
#include "sim_hal/emulator/mujoco/hand_world_plant.hpp"
#include "sim_hal/emulator/mujoco/krc_world_plant.hpp"
#include "sim_hal/emulator/mujoco/video_world_source.hpp"
#include "tools/rig/ros2_rig.hpp"

namespace colift::tools {
namespace {

/// Behind a gateway as a robot's file names it, or on an interface of this machine.
hal::Result<std::unique_ptr<hal::CanBus>> far_end_of(const std::string& can) {
  if (can.starts_with("socketcan:")) return hal::make_can_bus(can);
  const auto gateway = sim_hal::gateway_config(can);
  if (!gateway) return tl::unexpected(gateway.error());
  return std::make_unique<sim_hal::HandGateway>(*gateway);
}

/// Where the emulated camera is served: the file's address, or one of its own.
std::string camera_address(const std::string& source) {
  constexpr std::string_view kEmulated = "emulated:";
  return source.starts_with(kEmulated) ? source.substr(kEmulated.size()) : "";
}

}  // namespace

EmulatedRigConfig emulated_rig_of(const RobotFile& file, std::uint64_t seed) {
  EmulatedRigConfig config;
  config.arm_client.port = static_cast<std::uint16_t>(file.fri.port);
  config.script = file.fri.script;
  config.cpu = file.fri.cpu;
  if (file.hand == "barrett") config.can = file.barrett.can;
  if (file.camera == "kinect") config.camera = camera_address(file.kinect.source);
  if (file.camera == "openni2") config.camera = camera_address(file.openni2.source);
  if (file.camera == "ros2") config.serve_camera = emulated_ros2_camera(file.ros2);
  for (const MoreCamera& more : file.more_cameras)
    config.more_cameras.push_back(
        camera_address(more.camera == "openni2" ? more.openni2.source : more.kinect.source));
  config.seed = seed;
  return config;
}

EmulatedRig::EmulatedRig(std::shared_ptr<sim_hal::SimWorld> world, Faults faults)
    : world_(std::move(world)), faults_(std::move(faults)) {}

EmulatedRig::~EmulatedRig() {
  stop();
}

hal::Result<EmulatedRig::Faults> EmulatedRig::faults_of(const sim_hal::Scenario& scenario,
                                                        const EmulatedRigConfig& config) {
  for (std::size_t i = 0; i < scenario.faults.size(); ++i)
    if (!scenario.faults[i].in_state.empty())
      return hal::failure(hal::ErrorCode::BadConfig, fmt::format("faults[{}].at", i),
                          "emulated devices do not know the task's state; expected at_s");
  auto arm = sim_hal::faults_of("arm", scenario.faults, {}, sim_hal::krc_fault, sim_hal::parse_krc_fault);
  if (!arm) return tl::unexpected(arm.error());
  auto hand = sim_hal::faults_of("hand", scenario.faults, {}, sim_hal::hand_fault, sim_hal::parse_hand_fault);
  if (!hand) return tl::unexpected(hand.error());
  Faults faults{std::move(*arm), std::move(*hand), {}, {}};
  if (config.serve_camera) return faults;  // it has its own
  if (config.video) {
    auto device =
        sim_hal::faults_of("camera", scenario.faults, {}, sim_hal::video_fault, sim_hal::parse_video_fault);
    if (!device) return tl::unexpected(device.error());
    faults.video = std::move(*device);
    return faults;
  }
  for (std::size_t n = 0; n <= scenario.more_cameras.size(); ++n) {
    auto camera = sim_hal::faults_of(hal::camera_name(n), scenario.faults, {}, sim_hal::camera_fault,
                                     sim_hal::parse_camera_fault);
    if (!camera) return tl::unexpected(camera.error());
    faults.cameras.push_back(std::move(*camera));
  }
  return faults;
}

hal::Result<std::shared_ptr<EmulatedRig>> EmulatedRig::start(const EmulatedRigConfig& config,
                                                             const sim_hal::Scenario& scenario,
                                                             const hal::RobotModel& model,
                                                             std::shared_ptr<sim_hal::SimWorld> world) {
  auto faults = faults_of(scenario, config);
  if (!faults) return tl::unexpected(faults.error());
  std::shared_ptr<EmulatedRig> rig(new EmulatedRig(std::move(world), std::move(*faults)));
  sim_hal::SimWorld& w = *rig->world_;

  sim_hal::KrcServerConfig krc;
  krc.krc.to = config.arm_client;
  krc.krc.cycle = w.config().arm_period;
  krc.krc.script = config.script;
  krc.krc.seed = config.seed;
  krc.cpu = config.cpu;
  const hal::ArmDynamics dynamics(model, hal::ArmDynamics::Load::Hand);
  rig->krc_ = std::make_unique<sim_hal::KrcServer>(krc, dynamics,
                                                   std::make_unique<sim_hal::KrcWorldPlant>(w, dynamics));
  w.start_at(hal::SteadyClock().now());
  if (auto started = rig->krc_->start(); !started) return tl::unexpected(started.error());

  if (config.can) {
    auto bus = far_end_of(*config.can);
    if (!bus) return tl::unexpected(bus.error());
    sim_hal::HandEmulatorConfig hand;
    hand.judges_pace = false;  // this machine's pace is nobody's fault
    hand.seed = config.seed;
    rig->pucks_ = std::make_unique<sim_hal::HandServer>(hand, std::make_unique<sim_hal::HandWorldPlant>(w),
                                                        std::move(*bus));
    if (auto started = rig->pucks_->start(); !started) return tl::unexpected(started.error());
  }
  if (config.camera) {
    sim_hal::CameraServerConfig camera;
    camera.address = *config.camera;
    camera.seed = config.seed;
    rig->camera_ =
        std::make_unique<sim_hal::CameraServer>(camera, std::make_unique<sim_hal::CameraWorldSource>(w));
    if (auto started = rig->camera_->start(); !started) return tl::unexpected(started.error());
    for (std::size_t n = 1; n <= w.scenario().more_cameras.size(); ++n) {
      camera.address = n <= config.more_cameras.size() ? config.more_cameras[n - 1] : "";
      camera.seed = config.seed + n;
      rig->more_cameras_.push_back(std::make_unique<sim_hal::CameraServer>(
          camera, std::make_unique<sim_hal::CameraWorldSource>(w, n)));
      if (auto started = rig->more_cameras_.back()->start(); !started) return tl::unexpected(started.error());
    }
  }
  if (config.video)
    rig->video_ = std::make_shared<sim_hal::EmulatedVideo>(
        config.video->first, std::make_unique<sim_hal::VideoWorldSource>(w, config.video->second),
        rig->clock_);
  if (config.serve_camera) {
    auto camera = config.serve_camera(w);
    if (!camera) return tl::unexpected(camera.error());
    rig->served_camera_ = std::move(*camera);
  }
  return rig;
}

void EmulatedRig::begin() {
  world_->begin_scenario();
  for (const auto& fault : faults_.arm) krc_->inject(fault);
  for (const auto& fault : faults_.hand)
    if (pucks_) pucks_->inject(fault);
  for (std::size_t n = 0; camera_ && n < faults_.cameras.size(); ++n)
    for (const auto& fault : faults_.cameras[n]) (n == 0 ? camera_ : more_cameras_[n - 1])->inject(fault);
  for (const auto& fault : faults_.video)
    if (video_) video_->inject(fault);
  if (served_camera_) served_camera_->begin();
}

void EmulatedRig::stop() {
  // the world's mover last
  if (camera_) camera_->stop();
  for (const auto& camera : more_cameras_) camera->stop();
  if (video_) video_->end();
  if (served_camera_) served_camera_->stop();
  if (pucks_) pucks_->stop();
  if (krc_) krc_->stop();
}

hal::Result<ServedRigSign> ServedRigSign::put_up(std::uint16_t port) {
  const auto refused = [&](const char* what) {
    return hal::failure(hal::ErrorCode::DeviceFault, fmt::format("fri.port {}", port), what);
  };
  const int socket = ::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (socket < 0) return refused("this machine gives no socket");
  ServedRigSign sign(socket);
  // an abstract name: no file that a killed program would leave behind
  const std::string name = fmt::format("colift-rig-{}", port);
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  std::copy(name.begin(), name.end(), address.sun_path + 1);
  const auto size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + 1 + name.size());
  if (::bind(socket, reinterpret_cast<const sockaddr*>(&address), size) != 0)
    return refused("a rig is served for it already, by another program");
  return sign;
}

ServedRigSign::~ServedRigSign() {
  if (socket_ >= 0) ::close(socket_);
}

}  // namespace colift::tools
