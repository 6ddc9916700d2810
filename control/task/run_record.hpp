#pragma once

#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "control/lift/load_balance.hpp"
#include "control/session/decide.hpp"
#include "control/session/scene_analysis.hpp"
#include "control/session/views/view_report.hpp"
#include "control/task/grip_quality.hpp"
#include "control/task/intent.hpp"
#include "control/task/machine/task_machine.hpp"
#include "control/test_lift/test_lift.hpp"
#include "hal/device.hpp"
#include "perception/calibration/arm_in_view/camera_correction.hpp"
#include "planner/motion/motion_planner.hpp"

namespace colift::control {

/// When the task came into a state, and why (robot's clock).
struct StateChange {
  hal::Timestamp at{0};
  Task state = Task::Observe;
  std::string reason;
};

/// One point of the curves of a lift, 30 a second from Close to Release.
struct LiftSample {
  double t_s = 0.0;
  Task state = Task::Lift;
  double palm_height_m = 0.0;  ///< Of the palm over where it closed.
  double object_rise_m = 0.0;  ///< Of the object's centre, from depth; NaN while not seen.
  double tilt_rad = 0.0;       ///< Of the object, from depth; NaN while not seen.
  double slip_m = 0.0;         ///< Of the object in the hand, from depth and joints; NaN while not seen.
  double load_n = 0.0;         ///< That the robot carries, from external torques.
  hal::Wrench wrench_W;        ///< Of the object on the hand, about the palm; zero before it was first felt.
  hal::Vec3 palm_W = hal::Vec3::Zero();
  /// Of the object against the reference frame; unset while not seen.
  std::optional<hal::Pose> X_WTnow_WTref;
};

/// Means and maxima of the hold, as the robot measured them (m, rad, kg; shares 0 to 1).
struct LiftSummary {
  double height_m = 0.0;
  double tilt_rad = 0.0;
  double share_robot = NAN;  ///< NaN where it is not known.
  double share_predicted = 0.0;
  double slip_m = 0.0;
  double mass_kg = NAN;              ///< NaN where it is not known.
  double load_n = 0.0;               ///< That the robot carried (N).
  bool load_steady = false;          ///< It had come to rest when the hold began.
  std::optional<LoadEstimate> load;  ///< Share and mass with their intervals and source.
  std::string load_reason;           ///< Why they are not known; else empty.
};

/// How long parts of a run took (s, ms).
struct RunTiming {
  std::optional<double> grasp_to_decision_s;  ///< Simulated or real time, from the start of the dwell's end.
  double decision_compute_ms = 0.0;
  double plan_ms = 0.0;
  double sim_s = 0.0;
  double wall_s = 0.0;
};

/// A lift of some millimetres, and what it told.
struct TestLiftRecord {
  hal::Timestamp at{0};
  int candidate = 0;  ///< Its id.
  double height_m = 0.0;
  std::optional<TestLift> known;  ///< Unset where it said nothing.
  std::string reason;
};

/// The partner was asked to grasp elsewhere.
struct AskRecord {
  hal::Timestamp at{0};
  hal::Vec3 place = hal::Vec3::Zero();  ///< W, m.
  std::string reason;
};

/// Something about a device that is worth saying, and when (robot's clock).
struct DeviceNote {
  hal::Timestamp at{0};
  std::string device, what;
};

/// Who was near the arm, and what that did to its speed; 15 a second.
struct SeparationSample {
  double t_s = 0.0;
  double distance_m = 0.0;          ///< Of the nearest person or thing; NaN: nobody within sight of the arm.
  double partner_distance_m = 0.0;  ///< The same for the partner who holds the object.
  double scale = 1.0;               ///< Of the planned speed.
};

/// What speed and separation monitoring did.
struct MonitorRecord {
  bool on = true;
  int stops = 0;           ///< How often the arm stopped for somebody.
  double waited_s = 0.0;   ///< For so long it stood.
  double min_scale = 1.0;  ///< Of its speed.
  std::optional<double>
      min_distance_m;  ///< While it was to move, without the partner's hand; unset: nobody near.
  int max_bodies = 0;  ///< At the same time.
  int frames = 0;
  double compute_ms = 0.0;                              ///< Of all frames.
  double hold_distance_m = 0.0, slow_distance_m = 0.0;  ///< Of a person: stops, slows the arm.
  std::vector<SeparationSample> curve;
};

/// Everything that a run leaves behind for screen, JSON and report.
struct RunRecord {
  enum class Result { Lifted, Aborted, Refused } outcome = Result::Refused;
  std::string reason;
  std::vector<StateChange> states;
  std::optional<SceneAnalysis> analysis;                          ///< Of the reference frame.
  std::optional<perception::CameraCorrection> camera_correction;  ///< Unset: switched off, or no scene yet.
  std::vector<ViewReport> views;                                  ///< By camera; empty before the scene.
  double unseen = NAN;  ///< Part of the space around the object that no camera sees; NaN: no object.
  std::optional<Outcome> decision;  ///< The one that was carried out, or the last that was tried.
  std::optional<hal::DepthFrame> frame_partner, frame_lifted;  ///< When decided; at the top.
  std::optional<planner::MotionPlan> plan;
  std::optional<GripQuality> grip;  ///< Of the last closed hand, when it was judged.
  std::vector<LiftSample> curve;
  std::vector<TestLiftRecord> test_lifts;
  std::vector<AskRecord> asked;
  std::vector<Intent> intents;
  std::optional<LiftSummary> lift;
  bool palm_springs = false;     ///< The arm lifted with the impedance of its palm, not of its joints.
  double energy_margin_j = NAN;  ///< Least level of the EnergyTank (J); NaN before the first lift.
  RunTiming timing;
  MonitorRecord monitor;
  std::vector<DeviceNote> faults;
  std::vector<std::string> realtime;  ///< What the machine granted to the arm's thread, where it has one.
  bool device_failed = false;         ///< Arm or hand were lost.
  bool hand_keeps_grip = false;       ///< The run ended with a closed hand that felt something in it.
};

}  // namespace colift::control
