#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "hal/config/range.hpp"
#include "hal/types/geometry.hpp"
#include "hal/types/result.hpp"

namespace colift::sim_hal {

using hal::Pose;
using hal::Vec3;

// One struct per block of a scenario file (schema colift.scenario/1). Frames: W = robot base, z = 0 the
// floor; object frame T: origin on the floor below the middle of the object, z up, x along the first size, at
// yaw 0 along Wx.

/// One rigid piece of an object of kind `bodies`, in T.
struct ScenarioPart {
  std::string shape = "box";  ///< box (size x y z) or cylinder (size radius length).
  std::vector<double> size;
  Vec3 xyz = Vec3::Zero();
  Vec3 rpy_deg = Vec3::Zero();
  double mass = 1.0;
};

/// The object to be carried (m, kg).
struct ScenarioObject {
  std::string kind = "table";  ///< table | box | cylinder | chair | bodies
  std::vector<double> size;
  double mass = 4.0;
  Vec3 cog_offset = Vec3::Zero();  ///< From the uniform-density centre, in T.
  Vec3 xyz = Vec3::Zero();         ///< Pose of T in W ...
  double yaw_deg = 0.0;            ///< ... turned about z.
  double friction = 0.7;
  std::vector<ScenarioPart> parts;
};

/// Somebody moves a piece of clutter in a straight line (W, m, m/s).
struct ClutterMove {
  double at_s = 0.0;
  Vec3 to = Vec3::Zero();  ///< Of its lowest middle point.
  double speed = 0.5;
};

/// A piece beside the object (W, m); sizes as in ScenarioPart. Fixed, unless it has moves.
struct ScenarioClutter {
  std::string shape = "box";
  std::vector<double> size;
  Vec3 xyz = Vec3::Zero();  ///< Of its lowest middle point.
  double yaw_deg = 0.0;
  std::vector<ClutterMove> moves{};  ///< In the order of their times.
};

/// Where the camera is and where it looks (W, m).
struct ScenarioCamera {
  Vec3 xyz{2.2, -0.9, 1.4};
  Vec3 look_at{0.7, 0.0, 0.3};
  std::string noise = "kinect";  ///< kinect | none
};

inline constexpr std::size_t kMaxMoreCameras = 3;

/// The states of the task that a time of a scenario may count from.
[[nodiscard]] const std::vector<std::string>& task_state_names();

/// What the partner does at a time (s since the start of the scenario, or since a state was first entered).
struct PartnerScriptEvent {
  double at_s = 0.0;
  /// let-go | move | stumble | sway | steps-aside | second-hand | confirm-lower | confirm-continue
  std::string action;
  std::optional<Vec3> to;           ///< New grasp in T, for move; place of the second hand.
  std::string in_state{};           ///< Of the task; empty: since the start.
  double force_n = 80.0;            ///< Of a stumble ...
  double for_s = 0.4;               ///< ... for so long (a sway: 2 s) ...
  std::optional<Vec3> direction{};  ///< ... this way in W; unset: away from the object's middle.
  double by_m = 0.02;               ///< How far his hand sways, and back again.
};

/// Who carries the other side, where and from when (T, m, s).
struct ScenarioPartner {
  std::string kind = "compliant";  ///< compliant | leader | support | none
  Vec3 grasp = Vec3::Zero();       ///< In T, on the surface.
  double arrives_s = 3.0;
  bool obliging = false;  ///< Takes hold elsewhere, or steps aside, when he is asked to.
  std::vector<PartnerScriptEvent> events;
};

/// A person beside the partner: comes along a path on the floor and does something at its end (W, m, m/s).
struct ScenarioPerson {
  double enters_s = 0.0;   ///< He appears at the start of the path ...
  std::string in_state{};  ///< ... so long after this state of the task was first entered; empty: the start.
  std::vector<Eigen::Vector2d> path;
  double speed = 1.2;
  std::string action = "stand";      ///< walk | stand | crouch | reach | sit, at the end of the path.
  std::string reach_to;              ///< robot-hand | object | between-fingers | under-object | point
  Vec3 point = Vec3::Zero();         ///< For reach_to: point.
  bool with_foot = false;            ///< He reaches with his right foot, else with his right hand.
  double hand_speed = 1.0;           ///< Of the hand or foot that reaches.
  std::optional<double> leaves_s{};  ///< He goes back along the path; unset: he stays.
};

/// What both do with the object (m, s).
struct ScenarioTask {
  std::string kind = "lift";
  double height = 0.05;
  double hold_s = 2.0;
};

/// What goes wrong with a device, and when (s since the start of the scenario, or since a state was first
/// entered).
struct DeviceFaultEvent {
  double at_s = 0.0;
  std::string device;  ///< camera | arm | hand | camera2 | camera3 | camera4
  std::string action;  ///< freeze | drop | unplug | corrupt | blind | late | silent, as the device can
  double for_s = 0.5;
  std::optional<double> value{};   ///< How much, where the action has a meaning for it.
  std::string puck{};              ///< F1 | F2 | F3 | spread of an emulated hand; empty: all.
  Vec3 direction{0.0, 0.0, -1.0};  ///< Of a push, in W.
  int link = 0;                    ///< What is pushed: 1 to 7 the link behind that joint, 0 the hand.
  std::string in_state{};          ///< Of the task; empty: since the start.

  /// Whether it is at work at a time of the scenario; never before its state.
  [[nodiscard]] bool active(double t_s) const {
    return in_state.empty() && t_s >= at_s && t_s < at_s + for_s;
  }
};

/// A whole scenario file.
struct Scenario {
  std::string name;  ///< Of the file, for people.
  ScenarioObject object;
  std::vector<ScenarioClutter> clutter;
  ScenarioCamera camera;
  std::vector<ScenarioCamera> more_cameras{};  ///< At most kMaxMoreCameras.
  ScenarioPartner partner;
  ScenarioTask task;
  std::vector<ScenarioPerson> people;
  std::vector<DeviceFaultEvent> faults;
};

/// Reads and checks a scenario. Errors: BadConfig with file:line:column, what was found, what was expected,
/// and the nearest known name for an unknown key.
[[nodiscard]] hal::Result<Scenario> load_scenario(const std::filesystem::path& file);
[[nodiscard]] hal::Result<Scenario> parse_scenario(const std::string& yaml, const std::string& name);

/// config/scenario/table.yaml, compiled in.
[[nodiscard]] Scenario built_in_scenario();

/// Entry whose time counts from a state of the task, "partner.events[0].at"; empty: there is none. Such a
/// scenario needs a world that is told the task's state.
[[nodiscard]] std::string relative_time(const Scenario& scenario);

/// Pose of the object frame T in W as the scenario starts.
[[nodiscard]] Pose object_pose(const ScenarioObject& object);

}  // namespace colift::sim_hal
