#include "tools/rig/back_ends.hpp"

#include <fmt/format.h>

#include "hal/drivers/barrett_can/make_barrett_hand.hpp"
#include "hal/drivers/barrett_can/pucks/puck_codec.hpp"
#include "hal/drivers/kinect/guarded_kinect.hpp"
#include "hal/drivers/kuka_fri/fri_arm.hpp"
#include "hal/guards/guarded_arm.hpp"
#include "hal/guards/guarded_hand.hpp"
#include "hal/os/make_can_bus.hpp"
#include "hal/os/udp_link.hpp"
#include "perception/calibration/calibration_file.hpp"
#include "sim_hal/mujoco/devices/sim_devices.hpp"
#include "sim_hal/mujoco/devices/sim_infrared.hpp"
#include "sim_hal/mujoco/sim_world.hpp"
#include "sim_hal/scenario/scenario.hpp"
#include "tools/rig/emulated_rig.hpp"
#include "tools/rig/rig_truth.hpp"
#include "tools/rig/rig_world.hpp"
#include "tools/rig/robot_file.hpp"

namespace colift::tools {
namespace {

using World = std::shared_ptr<sim_hal::SimWorld>;

/// Which devices go together in one run. A simulated arm steps its world, a wire's far end lets it run in
/// real time, and beside a real arm nobody moves one.
hal::Result<> check_together(const RobotFile& file, bool emulated, const std::string& where) {
  const auto refuse = [&](const char* reason) {
    return hal::failure(hal::ErrorCode::BadConfig, where, reason);
  };
  if (file.arm == "simulated") {
    if (file.hand == "barrett")
      return refuse("hand: barrett lives in real time, and arm: simulated does not; expected arm: fri");
    if (file.camera == "kinect")
      return refuse("camera: kinect lives in real time, and arm: simulated does not; expected arm: fri");
    return {};
  }
  if (emulated) return {};
  if (file.hand == "simulated")
    return refuse(
        "hand: simulated lives in a simulation that is not stepped beside a real arm; expected hand: "
        "barrett, "
        "or emulator: always");
  if (file.camera == "simulated")
    return refuse(
        "camera: simulated observes a simulation that is not stepped beside a real arm; expected camera: "
        "kinect, or emulator: always");
  return {};
}

hal::Error no_pose(const std::filesystem::path& robot) {
  return {hal::ErrorCode::BadConfig, robot.string(),
          fmt::format("no camera pose is configured; run colift calibrate --robot {} --out camera.yaml, "
                      "and name its result: calibration: camera.yaml",
                      robot.string())};
}

ArmLink link_of(const hal::FriArm& arm, EmulatedRig* emulated) {
  ArmLink link;
  const hal::FriStatus status = arm.status();
  const hal::AnswerTimes& times = arm.answer_times();
  link.cycles = status.received;
  link.answered = status.answered;
  link.lost = status.lost;
  link.answer_us = {times.percentile_us(0.5), times.percentile_us(0.99), times.percentile_us(0.999),
                    times.worst_us()};
  for (std::size_t i = 0; i < times.slow(); ++i)
    link.slow.push_back({hal::seconds(times.slow(i).arrived), hal::seconds(times.slow(i).answered)});
  if (emulated == nullptr) return link;
  const sim_hal::KrcReport report = emulated->krc().report();
  const sim_hal::KrcServerTiming timing = emulated->krc().timing();
  link.controller = ArmLink::Controller{
      report.sent, report.answered,      report.missed,           report.most_missed_in_a_row,
      timing.late, timing.worst_late_ms, report.missed_in_command};
  for (const auto& missed : timing.missed)
    link.controller->missed_at.push_back({missed.sent_s, missed.until_s});
  for (const auto& broken : report.broken_rules) link.controller->broken_rules.push_back(broken.reason);
  for (const auto& change : report.mode_changes)
    if (change.from == sim_hal::FriState::Command) link.controller->left_command.push_back(change.reason);
  return link;
}

hal::Result<std::unique_ptr<hal::Arm>> open_arm(const RobotFile& file, const World& world,
                                                const std::shared_ptr<EmulatedRig>& far_ends, Rig& rig) {
  if (file.arm == "simulated") return sim_hal::make_sim_arm(*world);
  const auto address = hal::parse_endpoint(file.fri.address + ":" + std::to_string(file.fri.port));
  if (!address) return tl::unexpected(address.error());
  auto fri = std::make_unique<hal::FriArm>(file.fri, hal::make_udp_link(*address), *rig.robot.clock);
  rig.arm_link = [driver = fri.get(), far_ends] { return link_of(*driver, far_ends.get()); };
  return fri;
}

hal::Result<std::unique_ptr<hal::Hand>> open_hand(const RobotFile& file, const World& world) {
  if (file.hand == "simulated") return sim_hal::make_sim_hand(*world);
  const auto filters = hal::barrett::hand_filters();
  auto bus = hal::make_can_bus(file.barrett.can, {filters.begin(), filters.end()});
  if (!bus) return tl::unexpected(bus.error());
  // a bus that is not there is said before the arm is asked for anything
  if (auto opened = (*bus)->open(); !opened) return tl::unexpected(opened.error());
  return hal::make_barrett_hand(std::move(*bus), file.barrett);
}

void open_camera(const RobotFile& file, const sim_hal::Scenario& scenario, const World& world,
                 EmulatedRig* far_ends, bool pose_known, const control::Config& config, Rig& rig) {
  if (file.camera == "simulated") {
    rig.robot.camera = sim_hal::make_sim_camera(*world);
    rig.infrared = sim_hal::make_sim_infrared(*world, {});
    return;
  }
  hal::KinectConfig kinect = file.kinect;
  if (far_ends != nullptr) {
    kinect.source = "emulated:" + far_ends->camera()->address();
    kinect.motor = true;
  }
  hal::CameraGuardConfig guard = config.guard_camera;
  // an ideal camera shows a scene at rest alike
  if (file.emulator != "never" && scenario.camera.noise == "none") guard.frozen_s = 0.0;
  std::optional<hal::Vec3> up_C;
  if (pose_known) up_C = rig.X_WC.linear().transpose() * hal::Vec3::UnitZ();
  hal::GuardedKinect made = hal::make_guarded_kinect(kinect, guard, *rig.robot.clock, up_C);
  rig.robot.camera = std::move(made.camera);
  rig.infrared = std::move(made.infrared);
}

}  // namespace

hal::Result<RunTask> read_task(const std::optional<std::filesystem::path>& scenario) {
  const auto read = read_scenario(scenario);
  if (!read) return tl::unexpected(read.error());
  return RunTask{read->name, read->task.height, read->task.hold_s};
}

hal::Result<Rig> open_rig(const RigRequest& request, const control::Config& config) {
  const auto& robot = request.robot;
  const auto file = read_robot_file(robot);
  if (!file) return tl::unexpected(file.error());
  const bool real_time = file->arm == "fri";
  const bool served_elsewhere = real_time && file->emulator == "auto" &&
                                ServedRigSign::is_up(static_cast<std::uint16_t>(file->fri.port));
  const bool emulated = real_time && file->emulator != "never" && !served_elsewhere;
  if (auto ok = check_together(*file, emulated, robot.value_or("").string()); !ok)
    return tl::unexpected(ok.error());
  Rig rig;
  rig.name = robot ? robot->filename().string() : "simulated rig";
  auto model = read_model(file->model);
  if (!model) return tl::unexpected(model.error());
  rig.model = std::move(*model);
  const auto read = read_scenario(request.scenario);
  if (!read) return tl::unexpected(read.error());

  if (!real_time || emulated || served_elsewhere)
    rig.X_WC = rig.true_X_WC = sim_hal::camera_pose(read->camera);
  const bool calibrated = !file->calibration.empty() && !request.calibrates;
  const bool pose_known = request.X_WC || calibrated || !real_time || emulated || served_elsewhere;
  if (!pose_known && !request.calibrates) return tl::unexpected(no_pose(*robot));
  if (calibrated) {
    const auto calibration = perception::load_calibration(file->calibration, config.calibration);
    if (!calibration) return tl::unexpected(calibration.error());
    rig.X_WC = calibration->X_BC();
  }
  if (request.X_WC) rig.X_WC = *request.X_WC;

  World world;
  if (!real_time || emulated) {
    auto made = make_world(*file, *read, *rig.model, request.seed);
    if (!made) return tl::unexpected(made.error());
    world = std::move(*made);
    rig.world = world;
    rig.truth = truth_of(world, rig.model, !real_time);
  }
  rig.home_rad = world ? world->arm_state().q_rad : sim_hal::SimConfig::home_rad();
  std::shared_ptr<EmulatedRig> far_ends;
  if (emulated) {
    auto started = EmulatedRig::start(emulated_rig_of(*file, request.seed), *read, *rig.model, world);
    if (!started) return tl::unexpected(started.error());
    far_ends = std::move(*started);
    rig.far_ends = far_ends;
    rig.begin = [far_ends] { far_ends->begin(); };
  }

  if (real_time) {
    rig.drive = control::Drive::Thread;
    rig.robot.clock = std::make_unique<hal::SteadyClock>();
  } else {
    rig.robot.clock = sim_hal::make_sim_clock(*world);
  }
  auto arm = open_arm(*file, world, far_ends, rig);
  if (!arm) return tl::unexpected(arm.error());
  rig.robot.arm = std::make_unique<hal::GuardedArm>(std::move(*arm), *rig.model, config.guard_arm);
  auto hand = open_hand(*file, world);
  if (!hand) return tl::unexpected(hand.error());
  rig.robot.hand = std::make_unique<hal::GuardedHand>(std::move(*hand), config.guard_hand);
  open_camera(*file, *read, world, far_ends.get(), pose_known, config, rig);
  return rig;
}

}  // namespace colift::tools
