#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "control/arm/arm_loop.hpp"
#include "control/session/watch.hpp"
#include "control/task/run_record.hpp"
#include "hal/robot.hpp"

namespace colift::control {

/// What a running job tells whoever watches it.
struct JobStatus {
  hal::Timestamp now{0};
  Task state = Task::Observe;
  hal::Timestamp since{0};     ///< When it came into this state.
  std::string because;         ///< Why it did.
  std::string doing;           ///< What it is doing in particular.
  std::optional<double> done;  ///< Part of the state's work that is done, 0 to 1.
  std::optional<hal::Vec3> partner_W;
  std::string partner_note;
  double load_n = 0.0;
  std::optional<double> height_m, tilt_rad, slip_m;
  const RunRecord* record = nullptr;  ///< As far as it is.
  /// The collision world, made once when the scene is known; null until then. Borrowed for the call.
  const perception::WorldMap* map = nullptr;
};

/// What the job calls while it runs; each may be empty.
struct JobHooks {
  std::function<void()> started;      ///< All devices are active: the job begins.
  std::function<bool()> interrupted;  ///< A person wants the program to end.
  std::function<void(const JobStatus&)>
      status;                               ///< Every 33 ms of the robot's time, and at each change of state.
  std::function<void(Task, Task)> changed;  ///< From, to: the moment for whoever keeps a diary.
  /// The partner is asked to take hold there (W).
  std::function<void(const hal::Vec3&)> asked;
  std::function<void(const ArmView&)> cycle;  ///< A cycle of the task is over; the arm as it left it.
};

/// What a job is asked to do beyond its configuration.
struct JobOptions {
  Method method = Method::Fast;
  std::uint64_t seed = 0;
  bool dry_run = false;        ///< Sees, decides and plans, moves nothing.
  double known_mass_kg = 0.0;  ///< Of the object, when somebody knows it; 0: estimated from the load.
  Drive drive = Drive::InStep;
  /// Replay of a run whose arm had a thread of its own: the view of each cycle of the task (ArmLoop::play).
  std::function<void(ArmView&)> recorded_views = {};
};

/// Does the whole job once: sees, waits for the partner, decides, plans, approaches, closes, lifts together,
/// holds, lowers, releases, retreats. The rules stand in task_machine; here is what is done in each state.
/// Each cycle looks what the arm, the hand and the camera have to say, and asks the arm's loop for what comes
/// next. The loop runs in the same thread (simulation in lock step) or in its own (Drive).
class TaskRunner {
 public:
  /// Robot, rig and configuration have to outlive the runner; `stopwatch` measures computing time only.
  TaskRunner(hal::Robot& robot, const RigView& rig, const Config& config, const JobOptions& options,
             const hal::Clock& stopwatch);
  ~TaskRunner();

  /// Errors: those of devices that cannot be configured or activated at the start; nothing has moved then.
  /// Everything later ends in a state and a record.
  [[nodiscard]] hal::Result<RunRecord> run(const JobHooks& hooks);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace colift::control
