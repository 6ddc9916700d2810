#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "control/arm/arm_commander.hpp"
#include "control/config/config.hpp"
#include "hal/infrared_camera.hpp"
#include "hal/robot.hpp"
#include "hal/robot_model/robot_model.hpp"
#include "hal/types/result.hpp"
#include "sim_hal/judge/verdict.hpp"
#include "tools/rig/arm_link.hpp"
#include "tools/rig/truth_sample.hpp"
#include "tools/visualization/scene/solid_scene.hpp"

namespace colift::tools {

/// What a simulated rig knows beyond its devices. Empty on a real one.
struct RigTruth {
  std::function<TruthSample(hal::Timestamp began)> sample;
  std::function<picture::SolidScene()> scene;         ///< Everything, where it is now.
  std::function<std::optional<hal::Vec3>()> partner;  ///< Where he holds the object.
  /// The partner is asked to grasp somewhere, or to step aside that way (W).
  std::function<void(const std::optional<hal::Vec3>& grasp_W, const std::optional<hal::Vec3>& aside_W)>
      ask_partner;
  /// A scenario's person confirmed since the last call: lowering; that the arm may continue.
  std::function<bool()> take_lower_confirmed, take_continue_confirmed;
  std::function<void(const std::string&)> task_state;  ///< The job has entered a state.
  std::function<sim_hal::Verdict(bool lifted)> judge;  ///< At the end of the job, which says so or not.
  double mass_kg = 0.0;
  hal::Vec3 cog = hal::Vec3::Zero();  ///< In W, at the start.
};

/// The devices of one run behind their guards, and what goes with them.
struct Rig {
  std::shared_ptr<void> world;     ///< Simulation behind the devices; outlives them.
  std::shared_ptr<void> far_ends;  ///< Emulators on that world.
  std::shared_ptr<const hal::RobotModel> model;
  hal::Robot robot;
  std::shared_ptr<hal::InfraredCamera> infrared;  ///< Where it is not the camera itself.
  hal::Pose X_WC = hal::Pose::Identity();
  std::vector<hal::Pose> X_WC_more;                      ///< Of hal::Robot::more_cameras.
  hal::Pose true_X_WC = hal::Pose::Identity();           ///< In simulation; X_WC may come from a calibration.
  hal::JointVector home_rad = hal::JointVector::Zero();  ///< Where the arm stands at the start.
  control::Drive drive = control::Drive::InStep;         ///< Who runs the arm's cycle.
  std::string name;
  bool simulated = true;  ///< Or emulated, here or in another program: no person is near it.
  std::optional<RigTruth> truth;
  std::function<void()> begin;        ///< Starts the scenario, when the devices are ready; may be empty.
  std::function<ArmLink()> arm_link;  ///< Empty where the arm has no wire.
};

/// In place of a scenario's file: a floor with nothing near the arm, for calibration.
inline constexpr const char* kClearedFloor = "(cleared floor)";

/// What a run does beyond its rig, as the scenario says.
struct RunTask {
  std::string scenario;  ///< Name, for people.
  double lift_height_m = 0.05, hold_s = 2.0;
};

/// Reads a scenario's name and task. Errors: BadConfig with file:line:column.
[[nodiscard]] hal::Result<RunTask> read_task(const std::optional<std::filesystem::path>& scenario);

/// Which devices, and what simulated ones stand in.
struct RigRequest {
  std::optional<std::filesystem::path> robot;     ///< Unset: the simulated rig.
  std::optional<std::filesystem::path> scenario;  ///< Unset: the built-in table.
  std::uint64_t seed = 1;
  std::optional<hal::Pose> X_WC;  ///< Of the camera, when somebody knows it better than robot and scenario.
  bool calibrates = false;        ///< The robot's calibration is to be made: it is not read.
  std::optional<std::filesystem::path> errors = {};  ///< Of a simulated rig's sensors; unset: ideal.
};

class WiredDevices;

/// Opens the devices; with wired_devices.cpp the only place that knows back ends by name. `wired`: those at
/// the end of a wire; nullptr: simulated ones alone. Errors: BadConfig with the place; what the devices say.
[[nodiscard]] hal::Result<Rig> open_rig(const RigRequest& request, const control::Config& config,
                                        const WiredDevices* wired);

}  // namespace colift::tools
