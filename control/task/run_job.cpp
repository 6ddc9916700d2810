#include "control/task/run_job.hpp"

#include "control/task/task_runner.hpp"

namespace colift::control {

hal::Result<RunRecord> run_job(hal::Robot& robot, const RigView& rig, const Config& config,
                               const JobOptions& options, const JobHooks& hooks,
                               const hal::Clock& stopwatch) {
  return TaskRunner(robot, rig, config, options, stopwatch).run(hooks);
}

}  // namespace colift::control
