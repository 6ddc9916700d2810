#include "tools/rig/back_ends.hpp"

#include <fmt/format.h>

#include "hal/guards/guarded_arm.hpp"
#include "hal/guards/guarded_hand.hpp"
#include "perception/calibration/calibration_file.hpp"
#include "sim_hal/imperfect/imperfect_devices.hpp"
#include "sim_hal/imperfect/rig_errors.hpp"
#include "sim_hal/mujoco/devices/sim_devices.hpp"
#include "sim_hal/mujoco/devices/sim_infrared.hpp"
#include "sim_hal/mujoco/sim_world.hpp"
#include "sim_hal/scenario/scenario.hpp"
#include "tools/rig/rig_truth.hpp"
#include "tools/rig/rig_world.hpp"
#include "tools/rig/robot_file.hpp"
#include "tools/rig/wired_devices.hpp"

namespace colift::tools {
namespace {

using World = std::shared_ptr<sim_hal::SimWorld>;

constexpr std::uint64_t kOwnErrors = 0x9e3779b97f4a7c15;  // any odd number: seeds far from each other

/// Which devices go together in one run. A simulated arm steps its world, a wire's far end lets it run in
/// real time, and beside a real arm nobody moves one.
hal::Result<> check_together(const RobotFile& file, bool emulated, const std::string& where) {
  const auto refuse = [&](const char* reason) {
    return hal::failure(hal::ErrorCode::BadConfig, where, reason);
  };
  if (file.arm == "simulated") {
    if (!file.more_cameras.empty())
      return refuse("more_cameras of a simulated rig stand in the scenario; expected none here");
    if (file.hand == "barrett")
      return refuse("hand: barrett lives in real time, and arm: simulated does not; expected arm: fri");
    if (file.camera == "kinect")
      return refuse("camera: kinect lives in real time, and arm: simulated does not; expected arm: fri");
    if (file.camera == "ros2")
      return refuse("camera: ros2 lives in real time, and arm: simulated does not; expected arm: fri");
    if (file.camera == "v4l2")
      return refuse("camera: v4l2 lives in real time, and arm: simulated does not; expected arm: fri");
    if (file.camera == "openni2")
      return refuse("camera: openni2 lives in real time, and arm: simulated does not; expected arm: fri");
    return {};
  }
  if (emulated) return {};
  if (file.hand == "simulated")
    return refuse(
        "hand: simulated lives in a simulation that is not stepped beside a real arm; expected hand: "
        "barrett, or emulator: always");
  if (file.camera == "simulated")
    return refuse(
        "camera: simulated observes a simulation that is not stepped beside a real arm; expected camera: "
        "kinect, ros2, v4l2 or openni2, or emulator: always");
  return {};
}

hal::Error no_pose(const std::filesystem::path& robot) {
  return {hal::ErrorCode::BadConfig, robot.string(),
          fmt::format("no camera pose is configured; run colift calibrate --robot {} --camera-at X,Y,Z --out "
                      "camera.yaml (X,Y,Z: about where the camera is in the arm's base, m), "
                      "and name its result: calibration: camera.yaml",
                      robot.string())};
}

}  // namespace

hal::Result<RunTask> read_task(const std::optional<std::filesystem::path>& scenario) {
  const auto read = read_scenario(scenario);
  if (!read) return tl::unexpected(read.error());
  return RunTask{read->name, read->task.height, read->task.hold_s};
}

hal::Result<Rig> open_rig(const RigRequest& request, const control::Config& config,
                          const WiredDevices* wired) {
  const auto& robot = request.robot;
  const auto file = read_robot_file(robot);
  if (!file) return tl::unexpected(file.error());
  const bool real_time = file->arm == "fri";
  if (real_time && wired == nullptr)
    return hal::failure(hal::ErrorCode::BadConfig, robot.value_or("").string(),
                        "names an arm on a wire, and this program has simulated devices alone");
  const bool served_elsewhere = real_time && file->emulator == "auto" && wired->served_elsewhere(*file);
  const bool emulated = real_time && file->emulator != "never" && !served_elsewhere;
  if (served_elsewhere && file->camera == "v4l2")
    return hal::failure(hal::ErrorCode::BadConfig, robot.value_or("").string(),
                        "the rig that another program serves has a Kinect; expected camera: kinect, or "
                        "emulator: always");
  if (auto ok = check_together(*file, emulated, robot.value_or("").string()); !ok)
    return tl::unexpected(ok.error());
  Rig rig;
  rig.name = robot ? robot->filename().string() : "simulated rig";
  auto model = read_model(file->model);
  if (!model) return tl::unexpected(model.error());
  rig.model = std::move(*model);
  auto read = read_scenario(request.scenario);
  if (!read) return tl::unexpected(read.error());
  std::optional<sim_hal::RigFigures> figures;
  std::optional<sim_hal::RigErrors> errors;
  if (request.errors) {
    if (file->arm != "simulated" || file->hand != "simulated" || file->camera != "simulated")
      return hal::failure(hal::ErrorCode::BadInput, "--rig",
                          "is for a rig of which arm, hand and camera are simulated");
    auto loaded = sim_hal::load_rig_figures(*request.errors);
    if (!loaded) return tl::unexpected(loaded.error());
    figures = std::move(*loaded);
    errors = sim_hal::draw_rig_errors(*figures, request.seed);
    *read = sim_hal::with_errors(std::move(*read), *errors);
    rig.name += ", " + request.errors->stem().string();
  }

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
  if (errors) rig.X_WC = rig.X_WC * errors->camera.X_CK;

  rig.simulated = !real_time || emulated || served_elsewhere;
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
    auto started = wired->start_far_ends(*file, request.seed, *read, world, rig);
    if (!started) return tl::unexpected(started.error());
    far_ends = std::move(*started);
    rig.far_ends = far_ends;
  }

  if (real_time) {
    rig.drive = control::Drive::Thread;
    rig.robot.clock = std::make_unique<hal::SteadyClock>();
  } else {
    rig.robot.clock = sim_hal::make_sim_clock(*world);
  }
  auto arm = file->arm == "simulated" ? sim_hal::make_sim_arm(*world) : wired->arm(*file, far_ends, rig);
  if (!arm) return tl::unexpected(arm.error());
  if (errors) arm = sim_hal::make_imperfect_arm(std::move(*arm), *rig.model, errors->arm);
  rig.robot.arm = std::make_unique<hal::GuardedArm>(std::move(*arm), *rig.model, config.guard_arm);
  auto hand = file->hand == "simulated" ? sim_hal::make_sim_hand(*world) : wired->hand(*file);
  if (!hand) return tl::unexpected(hand.error());
  if (errors) hand = sim_hal::make_imperfect_hand(std::move(*hand), errors->hand);
  rig.robot.hand = std::make_unique<hal::GuardedHand>(std::move(*hand), config.guard_hand,
                                                      real_time ? rig.robot.clock.get() : nullptr);
  if (file->camera == "simulated") {
    rig.robot.camera = sim_hal::make_sim_camera(*world);
    if (errors)
      rig.robot.camera = sim_hal::make_imperfect_camera(std::move(rig.robot.camera), errors->camera);
    rig.infrared = sim_hal::make_sim_infrared(*world, {});
    rig.robot.more_cameras = sim_hal::make_more_sim_cameras(*world);
    rig.X_WC_more = sim_hal::more_camera_poses(*read);
    for (std::size_t n = 0; figures && n < rig.X_WC_more.size(); ++n) {
      // each camera has errors of its own
      const auto own = sim_hal::draw_rig_errors(*figures, request.seed + kOwnErrors * (n + 1)).camera;
      rig.robot.more_cameras[n] = sim_hal::make_imperfect_camera(std::move(rig.robot.more_cameras[n]), own);
      rig.X_WC_more[n] = rig.X_WC_more[n] * own.X_CK;
    }
  } else if (auto made = wired->camera(*file, *read, far_ends.get(), pose_known, config, rig); !made) {
    return tl::unexpected(made.error());
  } else if (auto more = wired->more_cameras(*file, *read, far_ends.get(), config, rig); !more) {
    return tl::unexpected(more.error());
  }
  return rig;
}

}  // namespace colift::tools
