#pragma once

#include <algorithm>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "hal/config/range.hpp"
#include "sim_hal/scenario/scenario.hpp"

namespace colift::sim_hal {

// A scenario file as it is written, block by block, with what each entry may be. What a kind asks of its
// entries together is checked in scenario.cpp.

inline constexpr hal::Range kSize_m{0.001, 5.0};
inline constexpr hal::Range kPlace_m{-20.0, 20.0};
inline constexpr hal::Range kAngle_deg{-360.0, 360.0};
inline constexpr hal::Range kMass_kg{0.001, 100.0};
inline constexpr hal::Range kFriction{std::numeric_limits<double>::min(), 3.0};
inline constexpr hal::Range kHeight_m{std::numeric_limits<double>::min(), 0.5};
inline constexpr hal::Range kTime_s{0.0, 36000.0};
inline constexpr hal::Range kForce_n{1.0, 500.0};
inline constexpr hal::Range kSpeed_m_s{0.01, 3.0};

struct PoseBlock {
  Vec3 xyz = Vec3::Zero();
  double yaw_deg = 0.0;

  template <class Visitor>
  void visit(Visitor& v) {
    v("xyz", xyz, kPlace_m, "Of the object frame in the robot base frame (m).");
    v("yaw_deg", yaw_deg, kAngle_deg, "Turn about the vertical (deg).");
  }
};

struct PartBlock {
  std::string shape;
  std::vector<double> size;
  Vec3 xyz = Vec3::Zero(), rpy_deg = Vec3::Zero();
  std::optional<double> mass;

  template <class Visitor>
  void visit(Visitor& v) {
    constexpr auto kRequired = hal::Presence::Required;
    v("shape", shape, hal::Choices{"box", "cylinder"}, "What it is.", kRequired);
    v("size", size, kSize_m, "box: x, y, z; cylinder: radius, length (m).", kRequired);
    v("xyz", xyz, kPlace_m, "Middle of the piece in the object frame (m).", kRequired);
    v("rpy_deg", rpy_deg, kAngle_deg, "Roll, pitch, yaw about the fixed axes (deg).");
    v("mass", mass, kMass_kg, "Of this piece (kg); all pieces have one, or none.");
  }
};

struct ObjectBlock {
  std::string kind;
  std::vector<double> size;
  std::optional<double> mass;
  Vec3 cog_offset = Vec3::Zero();
  PoseBlock pose;
  double friction = 0.7;
  std::vector<PartBlock> parts;

  template <class Visitor>
  void visit(Visitor& v) {
    v("kind", kind, hal::Choices{"table", "box", "cylinder", "chair", "bodies"}, "What it is.",
      hal::Presence::Required);
    v("size", size, kSize_m, "As the kind asks (m).");
    v("mass", mass, kMass_kg, "Of the whole object (kg).");
    v("cog_offset", cog_offset, kPlace_m, "Centre of gravity from that of uniform density (m).");
    v("pose", pose, "Where the object stands.");
    v("friction", friction, kFriction, "Coefficient of sliding friction.");
    v("parts", parts, "Pieces of kind bodies.");
  }
};

struct MoveBlock {
  double at_s = 0.0, speed = ClutterMove{}.speed;
  Vec3 to = Vec3::Zero();

  template <class Visitor>
  void visit(Visitor& v) {
    v("at_s", at_s, kTime_s, "When (s).", hal::Presence::Required);
    v("to", to, kPlace_m, "New lowest middle point in the robot base frame (m).", hal::Presence::Required);
    v("speed", speed, kSpeed_m_s, "How fast (m/s).");
  }
};

struct ClutterBlock {
  std::string shape;
  std::vector<double> size;
  Vec3 xyz = Vec3::Zero();
  double yaw_deg = 0.0;
  std::vector<MoveBlock> moves;

  template <class Visitor>
  void visit(Visitor& v) {
    constexpr auto kRequired = hal::Presence::Required;
    v("shape", shape, hal::Choices{"box", "cylinder"}, "What it is; a cylinder stands upright.", kRequired);
    v("size", size, kSize_m, "box: x, y, z; cylinder: radius, length (m).", kRequired);
    v("xyz", xyz, kPlace_m, "Lowest middle point in the robot base frame (m).", kRequired);
    v("yaw_deg", yaw_deg, kAngle_deg, "Turn about the vertical (deg).");
    v("moves", moves, "Where somebody moves it, in the order of time.");
  }
};

struct CameraBlock {
  Vec3 xyz = ScenarioCamera{}.xyz, look_at = ScenarioCamera{}.look_at;
  std::string noise = ScenarioCamera{}.noise;

  template <class Visitor>
  void visit(Visitor& v) {
    v("xyz", xyz, kPlace_m, "Where the camera is (m).");
    v("look_at", look_at, kPlace_m, "The point in the middle of its image (m).");
    v("noise", noise, hal::Choices{"kinect", "none"}, "How it measures.");
  }
};

inline constexpr double kSway_s = 2.0;  // for_s of a sway, where the file has none

struct EventBlock {
  std::optional<double> at_s;
  std::string at, action;
  std::optional<Vec3> to, direction;
  std::optional<double> force, for_s, by;

  template <class Visitor>
  void visit(Visitor& v) {
    v("at_s", at_s, kTime_s, "When (s).");
    v("at", at, "When: state of the task and seconds since it was first entered, lift+0.7.");
    v("do", action,
      hal::Choices{"let-go", "move", "stumble", "sway", "steps-aside", "second-hand", "confirm-lower",
                   "confirm-continue"},
      "What the partner does.", hal::Presence::Required);
    v("to", to, kPlace_m, "Where he grasps, in the object frame (m).");
    v("force", force, kForce_n, "Pull of a stumble (N).");
    v("for_s", for_s, kTime_s, "How long a stumble or a sway lasts (s).");
    v("direction", direction, kPlace_m, "Where he pulls or sways to, in the robot base frame.");
    v("by", by, hal::Range{0, 0.2}, "How far his hand sways (m).");
  }
};

struct PartnerBlock {
  std::string kind = ScenarioPartner{}.kind;
  Vec3 grasp = Vec3::Zero();
  double arrives_s = ScenarioPartner{}.arrives_s;
  bool obliging = ScenarioPartner{}.obliging;
  std::vector<EventBlock> events;

  template <class Visitor>
  void visit(Visitor& v) {
    v("kind", kind, hal::Choices{"compliant", "leader", "support", "none"}, "How the partner lifts.");
    v("grasp", grasp, kPlace_m, "Where he grasps, in the object frame (m).");
    v("arrives_s", arrives_s, kTime_s, "When his hand is on the object (s).");
    v("obliging", obliging, "Whether he grasps elsewhere, or steps aside, when the robot asks him to.");
    v("events", events, "What he does later.");
  }
};

/// The path is a list of [x, y], and reach_to may be a point: scenario_lists.hpp.
struct PersonBlock {
  std::optional<double> enters_s;
  std::vector<double> path;
  double speed = ScenarioPerson{}.speed, hand_speed = ScenarioPerson{}.hand_speed;
  std::string action = ScenarioPerson{}.action, reach_to, with, enters;
  std::optional<Vec3> point;
  std::optional<double> leaves_s;

  template <class Visitor>
  void visit(Visitor& v) {
    v("enters_s", enters_s, kTime_s, "When he appears at the start of his path (s).");
    v("enters", enters, "The same since a state of the task was first entered, approach+0.5.");
    v("path", path, kPlace_m, "Points on the floor, [x, y] each (m).", hal::Presence::Required);
    v("speed", speed, kSpeed_m_s, "How fast he walks (m/s).");
    v("do", action, hal::Choices{"walk", "stand", "crouch", "reach", "sit"}, "What he does at its end.");
    v("reach_to", reach_to,
      hal::Choices{"", "robot-hand", "object", "between-fingers", "under-object", "point"},
      "Where he reaches.");
    v("point", point, kPlace_m, "The point that he reaches for (m).");
    v("with", with, hal::Choices{"", "hand", "foot"}, "What he reaches with.");
    v("hand_speed", hand_speed, kSpeed_m_s, "How fast the hand or foot moves that reaches (m/s).");
    v("leaves_s", leaves_s, kTime_s, "When he goes back along his path (s).");
  }
};

struct TaskBlock {
  std::string kind = ScenarioTask{}.kind;
  double height = ScenarioTask{}.height, hold_s = ScenarioTask{}.hold_s;

  template <class Visitor>
  void visit(Visitor& v) {
    v("kind", kind, hal::Choices{"lift"}, "What is to be done.");
    v("height", height, kHeight_m, "How high (m).");
    v("hold_s", hold_s, kTime_s, "How long at the top (s).");
  }
};

struct FaultBlock {
  std::optional<double> at_s;
  std::string at, device, action, puck;
  std::optional<double> value;
  Vec3 direction = DeviceFaultEvent{}.direction;
  int link = 0;
  double for_s = DeviceFaultEvent{}.for_s;

  /// What only the arm's controller and its wire can do, and only an emulated one does.
  static const hal::Choices& of_controller() {
    static const hal::Choices all{"loss",        "delay",         "reorder",       "duplicate",
                                  "burst",       "quality",       "monitor",       "emergency-stop",
                                  "drive-error", "drive-warning", "drives-off",    "temperature",
                                  "jump",        "nan",           "torque-offset", "contact"};
    return all;
  }
  /// The same of the hand's pucks and its bus.
  static const hal::Choices& of_pucks() {
    static const hal::Choices all{"loss",  "duplicate", "wrong",   "reset",    "error",   "hot",
                                  "stuck", "jump",      "off",     "foreign",  "bus-off", "down",
                                  "noise", "full",      "passive", "brown-out"};
    return all;
  }
  /// The same of a Kinect behind libfreenect's functions.
  static const hal::Choices& of_kinect() {
    static const hal::Choices all{"slow", "double", "swap", "restamp", "packets", "zeros",
                                  "half", "moved",  "hang", "crash",   "holes"};
    return all;
  }
  static hal::Choices choices() {
    hal::Choices all{"freeze", "drop", "unplug", "corrupt", "blind", "late", "silent", "push"};
    for (const hal::Choices& more : {of_controller(), of_pucks(), of_kinect()})
      for (const std::string& name : more.names)
        if (std::find(all.names.begin(), all.names.end(), name) == all.names.end()) all.names.push_back(name);
    return all;
  }

  template <class Visitor>
  void visit(Visitor& v) {
    constexpr auto kRequired = hal::Presence::Required;
    v("at_s", at_s, kTime_s, "When (s).");
    v("at", at, "When: state of the task and seconds since it was first entered, lift+0.7.");
    v("device", device, hal::Choices{"camera", "arm", "hand", "camera2", "camera3", "camera4"},
      "Which device fails; camera2 is the first of more_cameras.", kRequired);
    v("do", action, choices(), "How it fails.", kRequired);
    v("value", value, hal::Range{-1e6, 1e6},
      "How much, where that has a meaning (hot: deg C, late: ms, loss: %, push: N).");
    v("puck", puck, hal::Choices{"", "F1", "F2", "F3", "spread"}, "Which puck of the hand; none: all.");
    v("direction", direction, hal::Range{-1e3, 1e3}, "Of a push, in the robot base frame; any length.");
    v("link", link, hal::Range{0, 7}, "What is pushed: 1 to 7 the link behind that joint; 0: the hand.");
    v("for_s", for_s, kTime_s, "How long (s).");
  }
};

struct ScenarioBlock {
  std::string schema;
  ObjectBlock object;
  std::vector<ClutterBlock> clutter;
  CameraBlock camera;
  std::vector<CameraBlock> more_cameras;
  PartnerBlock partner;
  TaskBlock task;
  std::vector<PersonBlock> people;
  std::vector<FaultBlock> faults;

  template <class Visitor>
  void visit(Visitor& v) {
    v("schema", schema, hal::Choices{"colift.scenario/1"}, "Which rules this file follows.",
      hal::Presence::Required);
    v("object", object, "What is lifted.");
    v("clutter", clutter, "What stands around.");
    v("camera", camera, "Where the camera is.");
    v("more_cameras", more_cameras, "Other cameras that look at the same scene; up to three.");
    v("partner", partner, "Who lifts along.");
    v("task", task, "What is to be done.");
    v("people", people, "Who else is in the room.");
    v("faults", faults, "What fails.");
  }
};

/// "lift+0.7" as state and seconds; nothing when it is no such text.
[[nodiscard]] std::optional<std::pair<std::string, double>> parse_relative(std::string_view text);

/// The scenario that a file says; what a kind asks of its entries together has been checked.
[[nodiscard]] Scenario scenario_of(const ScenarioBlock& file);

}  // namespace colift::sim_hal
