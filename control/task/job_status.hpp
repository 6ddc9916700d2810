#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "control/arm/drive.hpp"
#include "control/session/perception_session.hpp"
#include "control/task/job_policies.hpp"
#include "control/task/run_record.hpp"

namespace colift::control {

struct ArmView;  ///< One cycle of the arm (control/arm/arm_controller.hpp).

/// Who is near the arm, and what that means for its speed.
struct SeparationStatus {
  /// One body of the newest frame.
  struct Body {
    int id = 0;
    bool partner = false;
    hal::Aabb box;  ///< Of what is seen of it (W).
    hal::Vec3 center_W = hal::Vec3::Zero(), velocity_m_s = hal::Vec3::Zero();
    std::optional<double> distance_m;  ///< To the arm or the rest of its path; unset where it is far.
  };
  bool on = true;
  double scale = 1.0;  ///< Of the planned speed.
  bool waits = false;  ///< The arm stands on its path ...
  bool may_confirm =
      false;           ///< ... nobody is near any more, and an operator has to confirm that it may continue.
  std::string reason;  ///< Why it is slowed or stands; empty: it is not.
  std::optional<double> distance_m;
  double hold_distance_m = 0.0;  ///< A person nearer than that stops the arm.
  double slow_distance_m = 0.0;  ///< A person nearer than that slows it.
  std::vector<Body> bodies;
  double compute_ms = 0.0;
};

/// What the arm feels that nobody expects, and how much of it would stop it.
struct ForceStatus {
  bool on = true;
  hal::Vec3 felt_W = hal::Vec3::Zero();  ///< On the hand, against the empty hand at rest (N).
  std::optional<ForceLimits> limits;     ///< Of this state; unset: the empty hand's contact threshold counts.
  bool exceeded = false;                 ///< The arm has stopped for it.
};

/// What a running job reports to whoever watches it.
struct JobStatus {
  hal::Timestamp now{0};
  Task state = Task::Observe;
  hal::Timestamp since{0};     ///< When it came into this state.
  std::string reason;          ///< Why it did.
  std::string doing;           ///< What it is doing in particular.
  std::optional<double> done;  ///< Fraction of the state's work that is done, 0 to 1.
  std::optional<hal::Vec3> partner_W;
  std::string partner_note;
  double load_n = 0.0;
  std::optional<double> height_m, tilt_rad, slip_m;
  std::optional<double> share_robot;  ///< That the robot carries, while held up.
  SeparationStatus separation;
  ForceStatus force;
  const RunRecord* record = nullptr;  ///< As far as it is.
  /// The collision world; null until the scene is known. Borrowed for the call.
  const perception::WorldMap* map = nullptr;
  int map_version = 0;  ///< Another number: the map has changed.
};

/// Where object and partner are in one frame. What that frame does not show is unset: nothing here is older.
struct TrackedPoses {
  hal::Timestamp at{0};  ///< Exposure of the frame (robot's clock).
  /// Of the object's box: origin in its centre, axes along its edges. From the scene's own look, and from
  /// each frame in which the carried object is followed.
  std::optional<hal::Pose> X_WO;
  std::optional<hal::Vec3> partner_W;  ///< Contact of his hand, seen in this frame.
};

/// What is asked of the partner; one of both is set. The sentence goes out as an intent.
struct PartnerAsk {
  std::optional<hal::Vec3> grasp_W;  ///< To grasp the object there (W).
  std::optional<hal::Vec3> aside_W;  ///< To step aside, that way (W, horizontal, length 1).
};

/// What the job calls while it runs; each may be empty.
struct JobHooks {
  std::function<void()> started;      ///< All devices are active: the job begins.
  std::function<bool()> interrupted;  ///< A person wants the program to end.
  /// Asked in every cycle, and true once for each confirmation: one that nothing waits for has no effect.
  /// A person confirms that a paused object may be lowered ...
  std::function<bool()> lower_confirmed;
  /// ... that an arm which stopped for somebody may continue (MonitorConfig::resume).
  std::function<bool()> continue_confirmed;
  std::function<void(const JobStatus&)>
      status;  ///< Every 33 ms of the robot's time, and at each change of state.
  std::function<void(const TrackedPoses&)> tracked;  ///< A frame shows the object, the partner, or both.
  std::function<void(Task, Task)> changed;           ///< From, to: the moment for whoever keeps a diary.
  std::function<void(const PartnerAsk&)> asked;      ///< Something is asked of the partner.
  std::function<void(const ArmView&)> cycle;         ///< A cycle of the task is over; the arm as it left it.
};

/// What a job is asked to do beyond its configuration.
struct JobOptions {
  Method method = Method::Fast;
  std::uint64_t seed = 0;
  bool dry_run = false;  ///< Analyses, decides and plans, moves nothing.
  Drive drive = Drive::InStep;
  /// Replay of a run whose arm had a thread of its own: the view of each cycle of the task
  /// (ArmCommander::play).
  std::function<void(ArmView&)> recorded_views = {};
  JobPolicies policies = {};
};

}  // namespace colift::control
