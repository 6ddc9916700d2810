#pragma once

#include <string>

#include "control/config/certificate_config.hpp"
#include "control/config/check_config.hpp"
#include "control/config/load_config.hpp"
#include "control/config/method.hpp"
#include "control/config/monitor_config.hpp"
#include "control/config/recovery_config.hpp"
#include "control/config/setpoint_limits.hpp"
#include "control/config/task_config.hpp"
#include "control/config/test_lift_config.hpp"
#include "control/config/views_config.hpp"
#include "hal/config/range.hpp"
#include "hal/guards/guarded_arm.hpp"
#include "hal/guards/guarded_camera.hpp"
#include "hal/guards/guarded_hand.hpp"
#include "perception/bodies/body_finder.hpp"
#include "perception/bodies/body_tracker.hpp"
#include "perception/calibration/arm_in_view/camera_correction.hpp"
#include "perception/calibration/calibrate.hpp"
#include "perception/calibration/next_pose.hpp"
#include "perception/calibration/pose_check.hpp"
#include "perception/calibration/spot_finder.hpp"
#include "perception/ground/ground.hpp"
#include "perception/map/world_map.hpp"
#include "perception/motion/object_motion.hpp"
#include "perception/motion/raised_end.hpp"
#include "perception/noise_model.hpp"
#include "perception/partner/grasp_presence.hpp"
#include "perception/partner/partner_grasp.hpp"
#include "perception/partner/partner_tracker.hpp"
#include "perception/self_filter.hpp"
#include "perception/shape/shape_completion.hpp"
#include "perception/surfaces/surface_config.hpp"
#include "perception/target/target_config.hpp"
#include "perception/thesis/thesis_config.hpp"
#include "planner/grasp/grasp_candidates.hpp"
#include "planner/grasp/grasp_decision.hpp"
#include "planner/motion/motion_planner.hpp"

namespace colift::control {

/// Everything that can be set, by the names that YAML files, `--set` and `colift check` use. What a command
/// works with is made by resolve_config() alone.
struct Config {
  std::string method = "fast";
  std::string hand_file;
  std::string calibration_file;
  std::string arm_mode = "full";
  std::string support = "auto";
  perception::NoiseModel noise;
  perception::GroundConfig ground;
  perception::TargetConfig target;
  perception::SurfaceConfig surfaces;
  perception::CompletionConfig completion;
  planner::CandidateConfig candidates;
  perception::PartnerConfig partner;
  perception::TrackerConfig tracker{.dwell_s = 0.1};
  perception::RaiseConfig raise;
  perception::PresenceConfig presence;
  planner::DecisionConfig decision;
  CertificateConfig certificate;
  perception::ThesisConfig thesis;
  perception::WorldMapConfig map;
  perception::SelfFilterConfig self_filter;
  perception::MotionConfig object_motion;
  perception::BodyConfig bodies;
  perception::BodyTrackConfig body_tracks;
  ViewsConfig views;
  planner::PlannerConfig motion;
  TaskConfig task;
  MonitorConfig monitor;
  TestLiftConfig test_lift;
  RecoveryConfig recovery;
  LoadConfig load;
  SetpointLimits setpoints;
  MapCheckConfig map_check;
  ImageCheckConfig image_check;
  hal::GuardConfig guard_arm;
  hal::HandGuardConfig guard_hand;
  hal::CameraGuardConfig guard_camera;
  perception::CalibrationConfig calibration;
  perception::PoseConfig calibration_poses;
  perception::SpotConfig spot;
  perception::CorrectionConfig camera_correction;
  perception::PoseCheckConfig pose_check;

  template <class Visitor>
  void visit(Visitor& v) {
    v("method", method, hal::Choices{"fast", "thesis"},
      "Perception and decision: CoLift's own method, or the thesis's.");
    v("hand_file", hand_file, "Description of the hand; empty: the built-in BarrettHand BH8-282.");
    v("calibration_file", calibration_file,
      "Result of colift calibrate: where the camera is; empty: as the scenario or --camera-pose says.");
    v("arm_mode", arm_mode, hal::Choices{"full", "t1"},
      "How fast the arm may be: as limits allow, or as the KRC's mode T1 does (0.24 rad/s in each joint).");
    v("support", support, hal::Choices{"auto", "floor", "table"},
      "What the object stands on: the floor, a table top above it, or a table where nothing on the floor can "
      "be the target.");
    v("noise", noise, "Depth noise of the camera.");
    v("ground", ground, "How the ground is found.");
    v("target", target, "Which object is the target.");
    v("surfaces", surfaces, "How the object's faces are found.");
    v("completion", completion, "Shape completion of the unobserved side of the object.");
    v("candidates", candidates, "Where the hand may grasp.");
    v("partner", partner, "Detection of the partner's grasp.");
    v("tracker", tracker, "When a touch is a grasp.");
    v("raise", raise, "When an object that rises behind somebody's body is held by him.");
    v("presence", presence, "Whether the partner's hand is still at its grasp while the object moves.");
    v("decision", decision, "Load sharing.");
    v("certificate", certificate, "Bounds of share, tilt, slip and load that are said before a lift.");
    v("thesis", thesis, "Parameters of the thesis's method.");
    v("map", map, "The collision world.");
    v("self_filter", self_filter, "How the robot's own pixels are removed.");
    v("object_motion", object_motion, "How the object is followed while it is lifted.");
    v("bodies", bodies, "What counts as a foreign body, a person or a thing.");
    v("body_tracks", body_tracks, "How such bodies are followed over frames.");
    v("views", views, "How the views of several cameras are joined.");
    v("motion", motion, "Motion planning of the arm.");
    v("task", task, "The job: timeouts, lift, limits that end it.");
    v("monitor", monitor,
      "What slows and stops the arm beside the plan: people around it, unexpected force.");
    v("test_lift", test_lift, "Test lifts before the lift.");
    v("recovery", recovery, "Lowering, release and the motion home after a stop (colift recover).");
    v("load", load, "Estimation of the external wrench.");
    v("setpoints", setpoints, "Limits of the arm's set points: stops, corrections, ramps, contact.");
    v("map_check", map_check, "When a collision map is refused.");
    v("image_check", image_check, "When a depth image has too many holes.");
    v("guard_arm", guard_arm, "Limits that the guard of the arm enforces on every command.");
    v("guard_hand", guard_hand, "Limits that the guard of the hand enforces.");
    v("guard_camera", guard_camera, "Checks of every camera frame.");
    v("calibration", calibration, "How the camera's pose is calibrated, and when that is refused.");
    v("calibration_poses", calibration_poses, "Poses of the arm for a calibration.");
    v("spot", spot, "How the emitter is found in infrared images.");
    v("camera_correction", camera_correction,
      "Correction of the camera's calibration from the arm in its image.");
    v("pose_check", pose_check, "Whether the camera still is where its calibration says.");
  }
};

/// What `colift run` starts from: as Config, but the hand may move through space that the camera did not see,
/// because a moving arm feels what is there (docs/decisions/0009), and the thesis's perception fits the space
/// in front of the robot. Experiments and replays start from the same.
[[nodiscard]] Config run_defaults();

}  // namespace colift::control
