#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "control/task/run_record.hpp"
#include "hal/robot_model/robot_model.hpp"
#include "hal/types/geometry.hpp"
#include "sim_hal/judge/verdict.hpp"
#include "tools/rig/arm_link.hpp"
#include "tools/rig/truth_sample.hpp"
#include "tools/visualization/scene/solid_scene.hpp"

namespace colift::tools {

/// What the simulation knows and no device reports. About 30 samples a second from Close to Release.
struct RunTruth {
  double mass_kg = 0.0;
  hal::Vec3 cog = hal::Vec3::Zero();  ///< In W, before the lift.
  std::optional<hal::Vec3> partner;   ///< Where he held the object when it was decided (W).
  std::vector<TruthSample> curve;
  std::optional<sim_hal::Verdict> verdict;  ///< Of the world's own judge, when the job is over.
};

/// Where everything stood at one moment of a run.
struct FilmScene {
  double t_s = 0.0;  ///< Since the run began.
  control::Task state = control::Task::Observe;
  picture::SolidScene scene;
};

/// Where everything stood, for pictures. In simulation the world's shapes; without them the report draws
/// what was seen and planned.
struct RunScenes {
  std::optional<picture::SolidScene> before, lifted;  ///< Hand closed, still on the floor; at the top.
  std::vector<FilmScene> film;                        ///< From the approach on, evenly spaced; for a report.
};

/// What was asked for. All of it is known before the run starts.
struct RunSetting {
  std::string scenario;  ///< Name or file; empty on a real rig.
  std::string robot;     ///< "simulated rig", or the file that says which devices.
  std::string method = "fast";
  std::uint64_t seed = 0;
  std::optional<double> share;  ///< Wanted, 0 to 1.
  std::string command;          ///< The whole command line.
  bool simulated = true;
  bool dry_run = false;
  hal::Pose X_WC = hal::Pose::Identity();
  const hal::RobotModel* model = nullptr;  ///< Borrowed; null leaves the robot out of drawn pictures.
  hal::JointVector home_rad = hal::JointVector::Zero();
  double hand_opening_m = 0.19, palm_gap_m = 0.03;
  double lift_height_m = 0.05, hold_s = 2.0;       ///< Asked for.
  double max_tilt_rad = 0.087, max_slip_m = 0.02;  ///< Limits that end the lift.
  std::vector<std::pair<std::string, std::string>>
      config;  ///< What differs from the defaults: key, where set.
};

/// Everything about one finished run. Pointers and references are borrowed for the call.
struct RunView {
  const control::RunRecord& record;
  const RunSetting& setting;
  const RunTruth* truth = nullptr;    ///< Null on a real rig.
  const RunScenes* scenes = nullptr;  ///< Null: drawn from what was seen.
  const ArmLink* arm_link = nullptr;  ///< Null where the arm has no wire.
  std::string recovery = {};          ///< Document of the recovery after it; empty: there was none.
};

/// "lifted", "aborted", "refused".
[[nodiscard]] const char* word(control::RunRecord::Result outcome);

/// The robot's true part of the vertical force on the object at a sample, 0 to 1; NaN while the floor still
/// carries more than a tenth of it.
[[nodiscard]] double true_share(const TruthSample& sample);

/// True figures at the top of the lift: means over the Hold state, or over the last tenth of the lift where
/// there was none. nullopt when nothing was lifted.
struct TrueLift {
  double height_m = 0.0, tilt_rad = 0.0, share_robot = 0.0, slip_m = 0.0;
};
[[nodiscard]] std::optional<TrueLift> true_lift(const RunView& view);

/// Distance of the seen partner's grasp to the true one (m).
[[nodiscard]] std::optional<double> partner_error_m(const RunView& view);

}  // namespace colift::tools
