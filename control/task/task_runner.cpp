#include "control/task/task_runner.hpp"

#include "control/task/job.hpp"

namespace colift::control {

struct TaskRunner::Impl {
  hal::Robot& robot;
  Job job;
};

TaskRunner::TaskRunner(hal::Robot& robot, const RigView& rig, const Config& config, const JobOptions& options,
                       const hal::Clock& stopwatch)
    : impl_(new Impl{robot, Job(robot, rig, config, options, stopwatch)}) {}
TaskRunner::~TaskRunner() = default;

hal::Result<RunRecord> TaskRunner::run(const JobHooks& hooks) {
  if (auto started = impl_->job.start_devices(); !started) return tl::unexpected(started.error());
  if (hooks.started) hooks.started();
  while (impl_->job.cycle(hooks)) {
  }
  return impl_->job.finish();
}

}  // namespace colift::control
