#include "tools/rig/wired_devices.hpp"

#include <fmt/format.h>

#include "hal/drivers/barrett_can/make_barrett_hand.hpp"
#include "hal/drivers/barrett_can/pucks/puck_codec.hpp"
#include "hal/drivers/kinect/guarded_kinect.hpp"
#include "hal/drivers/kuka_fri/fri_arm.hpp"
#include "hal/drivers/v4l2_camera/v4l2_camera.hpp"
#include "hal/guards/guarded_camera.hpp"
#include "hal/os/make_can_bus.hpp"
#include "hal/os/udp_link.hpp"
#include "perception/calibration/calibration_file.hpp"
#include "sim_hal/mujoco/devices/sim_devices.hpp"
#include "tools/rig/emulated_rig.hpp"
#include "tools/rig/openni2_rig.hpp"
#include "tools/rig/ros2_rig.hpp"
#include "tools/rig/video_rig.hpp"

namespace colift::tools {
namespace {

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

hal::Result<std::unique_ptr<hal::DepthCamera>> guarded_openni2(const hal::Openni2CameraConfig& config,
                                                               const hal::CameraGuardConfig& guard,
                                                               const hal::Clock& clock) {
  auto made = make_openni2_camera(config, clock);
  if (!made) return tl::unexpected(made.error());
  return std::make_unique<hal::GuardedCamera>(std::move(*made), guard, clock);
}

hal::Result<std::unique_ptr<hal::DepthCamera>> real_camera(const MoreCamera& entry, const hal::Pose& X_WC,
                                                           const control::Config& config,
                                                           const hal::Clock& clock) {
  if (entry.camera == "ros2") return make_ros2_camera(entry.ros2, config.guard_camera, clock);
  if (entry.camera == "v4l2") {
    auto made = make_video_camera(entry.v4l2, clock);
    if (!made) return tl::unexpected(made.error());
    return std::make_unique<hal::GuardedCamera>(std::move(*made), config.guard_camera, clock);
  }
  if (entry.camera == "openni2") return guarded_openni2(entry.openni2, config.guard_camera, clock);
  const hal::Vec3 up_C = X_WC.linear().transpose() * hal::Vec3::UnitZ();
  return hal::make_guarded_kinect(entry.kinect, config.guard_camera, clock, up_C).camera;
}

/// What is in front of an emulated video device: a camera as the file describes it, else a usual one.
hal::Result<hal::v4l2::DepthModel> emulated_model(const hal::V4l2CameraConfig& config) {
  if (!config.intrinsics.empty()) return depth_model(config);
  hal::v4l2::DepthModel usual;
  if (config.depth_unit_m > 0.0) usual.unit_m = config.depth_unit_m;
  return usual;
}

hal::Result<> v4l2_camera(const RobotFile& file, EmulatedRig* far_ends, const hal::CameraGuardConfig& guard,
                          Rig& rig) {
  std::unique_ptr<hal::DepthCamera> camera;
  if (far_ends != nullptr) {
    const auto model = emulated_model(file.v4l2);
    if (!model) return tl::unexpected(model.error());
    camera = std::make_unique<hal::V4l2Camera>(file.v4l2, *model, far_ends->video(), *rig.robot.clock);
  } else {
    auto made = make_video_camera(file.v4l2, *rig.robot.clock);
    if (!made) return tl::unexpected(made.error());
    camera = std::move(*made);
  }
  rig.robot.camera = std::make_unique<hal::GuardedCamera>(std::move(camera), guard, *rig.robot.clock);
  return {};
}

class Wired final : public WiredDevices {
 public:
  [[nodiscard]] bool served_elsewhere(const RobotFile& file) const override {
    return ServedRigSign::is_up(static_cast<std::uint16_t>(file.fri.port));
  }

  [[nodiscard]] hal::Result<std::shared_ptr<EmulatedRig>> start_far_ends(
      const RobotFile& file, std::uint64_t seed, const sim_hal::Scenario& scenario,
      std::shared_ptr<sim_hal::SimWorld> world, Rig& rig) const override {
    EmulatedRigConfig wires = emulated_rig_of(file, seed);
    if (file.camera == "v4l2") {
      const auto model = emulated_model(file.v4l2);
      if (!model) return tl::unexpected(model.error());
      if (!model->lens.none())
        return hal::failure(hal::ErrorCode::BadConfig, file.v4l2.intrinsics,
                            "an emulated camera has no distortion; expected intrinsics without it");
      sim_hal::EmulatedVideoConfig video;
      video.path = file.v4l2.device;
      video.unit_m = model->unit_m;
      wires.video.emplace(video, model->intrinsics);
    }
    auto far_ends = EmulatedRig::start(wires, scenario, *rig.model, std::move(world));
    if (far_ends) rig.begin = [rig_ends = *far_ends] { rig_ends->begin(); };
    return far_ends;
  }

  [[nodiscard]] hal::Result<std::unique_ptr<hal::Arm>> arm(const RobotFile& file,
                                                           const std::shared_ptr<EmulatedRig>& far_ends,
                                                           Rig& rig) const override {
    const auto address = hal::parse_endpoint(file.fri.address + ":" + std::to_string(file.fri.port));
    if (!address) return tl::unexpected(address.error());
    auto fri = std::make_unique<hal::FriArm>(file.fri, hal::make_udp_link(*address), *rig.robot.clock);
    rig.arm_link = [driver = fri.get(), far_ends] { return link_of(*driver, far_ends.get()); };
    return fri;
  }

  [[nodiscard]] hal::Result<std::unique_ptr<hal::Hand>> hand(const RobotFile& file) const override {
    const auto filters = hal::barrett::hand_filters();
    auto bus = hal::make_can_bus(file.barrett.can, {filters.begin(), filters.end()});
    if (!bus) return tl::unexpected(bus.error());
    // a bus that is not there is said before the arm is asked for anything
    if (auto opened = (*bus)->open(); !opened) return tl::unexpected(opened.error());
    auto log = hal::make_bus_log(file.barrett);
    if (!log) return tl::unexpected(log.error());
    return hal::make_barrett_hand(std::move(*bus), file.barrett, std::move(*log));
  }

  [[nodiscard]] hal::Result<> camera(const RobotFile& file, const sim_hal::Scenario& scenario,
                                     EmulatedRig* far_ends, bool pose_known, const control::Config& config,
                                     Rig& rig) const override {
    hal::CameraGuardConfig guard = config.guard_camera;
    // an ideal camera shows a scene at rest alike
    if (file.emulator != "never" && scenario.camera.noise == "none") guard.frozen_s = 0.0;
    if (file.camera == "ros2") {
      auto made = make_ros2_camera(file.ros2, guard, *rig.robot.clock);
      if (!made) return tl::unexpected(made.error());
      rig.robot.camera = std::move(*made);
      return {};
    }
    if (file.camera == "v4l2") return v4l2_camera(file, far_ends, guard, rig);
    if (file.camera == "openni2") {
      hal::Openni2CameraConfig openni2 = file.openni2;
      if (far_ends != nullptr) openni2.source = "emulated:" + far_ends->camera()->address();
      auto made = guarded_openni2(openni2, guard, *rig.robot.clock);
      if (!made) return tl::unexpected(made.error());
      rig.robot.camera = std::move(*made);
      return {};
    }
    hal::KinectConfig kinect = file.kinect;
    if (far_ends != nullptr) {
      kinect.source = "emulated:" + far_ends->camera()->address();
      kinect.motor = true;
    }
    std::optional<hal::Vec3> up_C;
    if (pose_known) up_C = rig.X_WC.linear().transpose() * hal::Vec3::UnitZ();
    hal::GuardedKinect made = hal::make_guarded_kinect(kinect, guard, *rig.robot.clock, up_C);
    rig.robot.camera = std::move(made.camera);
    rig.infrared = std::move(made.infrared);
    return {};
  }

  [[nodiscard]] hal::Result<> more_cameras(const RobotFile& file, const sim_hal::Scenario& scenario,
                                           EmulatedRig* far_ends, const control::Config& config,
                                           Rig& rig) const override {
    std::vector<MoreCamera> entries = file.more_cameras;
    if (rig.simulated) rig.X_WC_more = sim_hal::more_camera_poses(scenario);
    if (far_ends != nullptr && far_ends->camera() == nullptr && !scenario.more_cameras.empty())
      return hal::failure(hal::ErrorCode::BadConfig, rig.name,
                          "more_cameras of a scenario are emulated beside camera: kinect or openni2 alone");
    if (far_ends != nullptr) {
      entries.resize(far_ends->more_cameras().size());
      for (std::size_t n = 0; n < entries.size(); ++n) {
        entries[n].camera = file.camera;
        entries[n].kinect.source = "emulated:" + far_ends->more_cameras()[n]->address();
        entries[n].openni2.source = entries[n].kinect.source;
        entries[n].kinect.motor = true;
      }
    }
    if (entries.size() > sim_hal::kMaxMoreCameras)
      return hal::failure(hal::ErrorCode::BadConfig, rig.name,
                          fmt::format("more_cameras holds {} cameras, expected at most {}", entries.size(),
                                      sim_hal::kMaxMoreCameras));
    rig.X_WC_more.resize(entries.size(), hal::Pose::Identity());
    for (std::size_t n = 0; n < entries.size(); ++n) {
      const bool by_scenario = rig.simulated && n < scenario.more_cameras.size();
      if (!entries[n].calibration.empty()) {
        const auto calibration = perception::load_calibration(entries[n].calibration, config.calibration);
        if (!calibration) return tl::unexpected(calibration.error());
        rig.X_WC_more[n] = calibration->X_BC();
      } else if (!by_scenario) {
        return hal::failure(
            hal::ErrorCode::BadConfig, rig.name,
            fmt::format("more_cameras[{}] has no calibration; calibrate it as the only camera "
                        "of a robot file, and name the result there",
                        n));
      }
      auto made = real_camera(entries[n], rig.X_WC_more[n], config, *rig.robot.clock);
      if (!made) return tl::unexpected(made.error());
      rig.robot.more_cameras.push_back(std::move(*made));
    }
    return {};
  }
};

}  // namespace

const WiredDevices& wired_devices() {
  static const Wired devices;
  return devices;
}

}  // namespace colift::tools
