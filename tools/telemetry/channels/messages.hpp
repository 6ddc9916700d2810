#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "control/arm/arm_controller.hpp"
#include "control/task/job_status.hpp"
#include "hal/device.hpp"
#include "hal/robot_model/robot_model.hpp"

namespace colift::telemetry {

// What stands in the messages of the JSON channels (channels.hpp). All are pure functions of product values,
// for recorder and live view alike. `at` is the robot's clock; `t_s` counts from the start of the run.

/// Names of frames.
inline constexpr const char* kWorldFrame = "world";
inline constexpr const char* kCameraFrame = "camera";  ///< Of the first; of others hal::camera_name().
inline constexpr const char* kObjectFrame = "object";
inline constexpr const char* kPartnerFrame = "partner";

[[nodiscard]] std::string transforms_message(hal::Timestamp at, const hal::RobotModel& model,
                                             const hal::JointVector& q_rad, const hal::HandPosture& hand,
                                             const hal::Pose& X_WC,
                                             std::span<const hal::Pose> X_WC_more = {});
/// Of "object" and "partner" what is set, stamped with the frame's exposure. Of the partner a point is known:
/// his frame has the axes of "world".
[[nodiscard]] std::string tracked_message(const control::TrackedPoses& tracked);
[[nodiscard]] std::string tactile_message(const hal::HandState& hand);
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
[[nodiscard]] std::string intent_message(const control::Intent& intent);
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
[[nodiscard]] std::string stages_message(const control::StageTimes& analysis, double decision_ms,
                                         const control::RunTiming& timing);

/// Force and share as they are now.
struct LoadNow {
  std::optional<hal::Wrench> wrench_W;
  double load_n = 0.0;
  std::optional<double> share, share_predicted, height_m, tilt_rad, slip_m;
  std::optional<double> energy_j = {};                ///< That it may still put in.
  std::optional<control::LiftController::Role> role;  ///< Of the robot, while it holds the object.
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

/// The open hand with its palm frame at the chosen grasp.
struct GripperView {
  hal::Pose X_WH = hal::Pose::Identity();
  std::vector<hal::LinkShape> hand_W;  ///< The hand's shapes; their X_LS is the pose in W.
};
[[nodiscard]] GripperView gripper_view(const hal::RobotModel& model, const hal::Pose& X_WH);

/// What the scene holds by now, for three-dimensional pictures. Entities keep their ids from message to
/// message: "ground", "target", "shape", "cog", "surface 3", "candidate 12", "partner", "optimum", "gripper",
/// "path".
struct SceneView {
  std::optional<perception::Ground> ground;
  hal::Vec3 target_center = hal::Vec3::Zero(), cog = hal::Vec3::Zero();
  std::optional<hal::OrientedBox> target, shape;
  std::vector<perception::Surface> surfaces;
  std::vector<planner::GraspCandidate> candidates;
  std::optional<perception::PartnerGrasp> partner;
  std::optional<hal::Vec3> optimum;
  std::optional<GripperView> gripper;
  std::vector<hal::Vec3> path_W;
};
[[nodiscard]] SceneView scene_view(const control::SceneAnalysis& analysis);
[[nodiscard]] std::string scene_message(hal::Timestamp at, const SceneView& scene);

/// Everybody near the arm: "body 3" with its box, its velocity as an arrow of half a second, and words.
[[nodiscard]] std::string bodies_message(hal::Timestamp at, const control::SeparationStatus& separation);

/// A part of the collision world, small enough to be sent: the cells near the robot, copied.
struct MapView {
  enum class Cell : std::uint8_t {
    Nothing,
    Obstacle,  ///< Measured, above the ground.
    Target,    ///< Of the object that is to be carried.
    Hidden,    ///< Behind what was measured: the arm keeps out of it too.
  };
  double cell_m = 0.02;
  hal::Vec3 origin_W = hal::Vec3::Zero();  ///< Lower corner of the first cell.
  std::array<int, 3> size{};               ///< Cells along x, y, z.
  std::vector<Cell> cells;                 ///< x fastest, then y.
  std::size_t cropped = 0;                 ///< Obstacle and target cells of the map outside of it.
};
/// The cells within 2 m of the robot's base; where those are more than four million, several make one. The
/// ground's own cells are left out: the planner has it as a plane. One pass over the map.
[[nodiscard]] MapView map_view(const perception::WorldMap& map, const hal::Plane& ground);
/// Entities "obstacles", "target", "hidden": cells of one kind as few boxes, at most some thousands, those
/// near the robot first; what was left out stands in the metadata.
[[nodiscard]] std::string map_message(hal::Timestamp at, const MapView& map);

}  // namespace colift::telemetry
