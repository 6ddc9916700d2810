#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "control/arm_motion.hpp"
#include "control/task_runner.hpp"
#include "hal/device.hpp"
#include "hal/robot_model/robot_model.hpp"

namespace colift::telemetry {

// What stands in the messages of the JSON channels (channels.hpp). All are pure functions of product values,
// for recorder and live view alike. `at` is the robot's clock; `t_s` counts from the start of the run.

/// Names of frames.
inline constexpr const char* kWorldFrame = "world";
inline constexpr const char* kCameraFrame = "camera";

[[nodiscard]] std::string transforms_message(hal::Timestamp at, const hal::RobotModel& model,
                                             const hal::JointVector& q_rad, const hal::HandPosture& hand,
                                             const hal::Pose& X_WC);
[[nodiscard]] std::string joints_message(hal::Timestamp at, const hal::RobotModel& model,
                                         const hal::ArmState& arm, const hal::HandState& hand);

[[nodiscard]] std::string calibration_message(hal::Timestamp at, const hal::CameraIntrinsics& camera);
/// Millimetres, half as wide and high as the frame; 0 where nothing was seen.
[[nodiscard]] std::string preview_message(const hal::DepthFrame& frame);
/// Every fourth pixel in both directions, in the camera's frame.
[[nodiscard]] std::string cloud_message(const hal::DepthFrame& frame);

enum class Level { Debug = 1, Info = 2, Warning = 3, Error = 4 };
[[nodiscard]] std::string log_message(hal::Timestamp at, Level level, const std::string& name,
                                      const std::string& text);

[[nodiscard]] std::string status_message(const control::JobStatus& status);
[[nodiscard]] std::string change_message(const control::StateChange& change);

struct NamedHealth {
  std::string name;
  hal::DeviceHealth health;
};
[[nodiscard]] std::string devices_message(const std::vector<NamedHealth>& devices);

/// The arm's cycle over a while.
struct CycleSummary {
  std::uint64_t cycles = 0, missed = 0, lost_samples = 0;
  std::optional<double> period_ms_max, answer_us_mean, answer_us_max;
};
[[nodiscard]] std::string timing_message(const CycleSummary& summary);
[[nodiscard]] std::string stages_message(const control::StageTimes& look, double decision_ms,
                                         const control::RunTiming& timing);

/// Force and share as they are now.
struct LoadNow {
  std::optional<hal::Wrench> wrench_W;
  double load_n = 0.0;
  std::optional<double> share, share_predicted, height_m, tilt_rad, slip_m;
};
[[nodiscard]] std::string load_message(const LoadNow& load);

/// A decision and the look that it rests on, kept as long as anybody may want it. Costs no copy of a frame.
struct DecisionView {
  double t_s = 0.0;
  control::Outcome outcome;
  std::optional<hal::Vec3> cog;
};
[[nodiscard]] std::string decision_message(const DecisionView& decision);

struct PlanView {
  double t_s = 0.0;
  double transit_s = 0.0, approach_s = 0.0;
  std::vector<hal::JointVector> postures;  ///< 25 along the whole way.
  std::vector<hal::Vec3> palm_W;           ///< Of each posture.
};
[[nodiscard]] PlanView plan_view(double t_s, const planner::MotionPlan& plan, const hal::RobotModel& model);
[[nodiscard]] std::string plan_message(const PlanView& plan);

/// What the scene holds by now, for three-dimensional pictures. Entities keep their ids from message to
/// message: "ground", "target", "surface 3", "candidate 12", "partner", "cog", "optimum", "way".
struct SceneView {
  std::optional<perception::Ground> ground;
  hal::Vec3 target_center = hal::Vec3::Zero(), cog = hal::Vec3::Zero();
  std::optional<hal::OrientedBox> target, shape;
  std::vector<perception::Surface> surfaces;
  std::vector<planner::GraspCandidate> candidates;
  std::optional<perception::PartnerGrasp> partner;
  std::optional<hal::Vec3> optimum;
  std::vector<hal::Vec3> way_W;
};
[[nodiscard]] SceneView scene_view(const control::Look& look);
[[nodiscard]] std::string scene_message(hal::Timestamp at, const SceneView& scene);

/// "chosen", "near-partner", ...: the words of all of CoLift's documents.
[[nodiscard]] const char* verdict_word(planner::Verdict verdict);

}  // namespace colift::telemetry
