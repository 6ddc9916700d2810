#pragma once

#include "control/task/job_status.hpp"
#include "hal/robot.hpp"

namespace colift::control {

/// Does the whole job once: observes, waits for the partner, decides, plans, approaches, closes, lifts
/// together, holds, lowers, releases, retreats (docs/task.md). Returns when the robot is at home again, or
/// where it had to stop; every outcome is a record with its reasons. Robot, rig and configuration are used
/// for the time of the call; `stopwatch` measures computing time only. With Drive::Thread the arm's cycle
/// runs in a thread of its own meanwhile; hooks are called from the caller's.
/// Errors: those of devices that cannot be configured or activated at the start; nothing has moved then.
[[nodiscard]] hal::Result<RunRecord> run_job(hal::Robot& robot, const RigView& rig, const Config& config,
                                             const JobOptions& options, const JobHooks& hooks,
                                             const hal::Clock& stopwatch);

}  // namespace colift::control
