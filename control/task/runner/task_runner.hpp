#pragma once

#include "control/task/grasp_selector.hpp"
#include "control/task/job_status.hpp"
#include "control/task/object_monitor.hpp"
#include "control/task/partner_monitor.hpp"
#include "control/task/partner_requests.hpp"
#include "control/task/phases/approach_phase.hpp"
#include "control/task/phases/back_off_phase.hpp"
#include "control/task/phases/contact_phase.hpp"
#include "control/task/phases/grip_phase.hpp"
#include "control/task/phases/lift_phase.hpp"
#include "control/task/phases/partner_phase.hpp"
#include "control/task/phases/pause_phase.hpp"
#include "control/task/phases/plan_phase.hpp"
#include "control/task/phases/retreat_phase.hpp"
#include "control/task/phases/scene_phase.hpp"
#include "control/task/phases/test_lift_phase.hpp"
#include "control/task/phases/yield_phase.hpp"
#include "control/task/supervision/arm_supervisor.hpp"
#include "control/task/supervision/camera_supervisor.hpp"
#include "control/task/supervision/hand_supervisor.hpp"
#include "control/task/supervision/separation_supervisor.hpp"
#include "control/task/supervision/speed_scaling.hpp"
#include "control/task/supervision/stall_supervisor.hpp"
#include "control/task/task_context.hpp"

namespace colift::control {

/// Behind run_job(): observes, waits for the partner, decides, plans, approaches, closes, lifts
/// together, holds, lowers, releases, retreats. The rules stand in task_machine; what is done in each state
/// stands in its phase. Each cycle reads arm, hand and camera, lets the phase of the state work, applies the
/// event that it reports, and asks the arm for what comes next. The arm's own cycle runs in the same thread
/// (simulation in lock step) or in a thread of its own (Drive).
class TaskRunner {
 public:
  /// Robot and rig have to outlive the runner; `stopwatch` measures computing time only.
  TaskRunner(hal::Robot& robot, const RigView& rig, const Config& config, const JobOptions& options,
             const hal::Clock& stopwatch);

  /// Once. Errors: those of devices that cannot be configured or activated at the start; nothing has moved
  /// then. Everything later ends in a state and a record.
  [[nodiscard]] hal::Result<RunRecord> run(const JobHooks& hooks);

 private:
  [[nodiscard]] hal::Result<> start();
  [[nodiscard]] hal::Result<> start_devices();
  /// One cycle. False when the job has ended.
  [[nodiscard]] bool cycle(const JobHooks& hooks);
  void read_devices();
  void hear_operator(const JobHooks& hooks);
  /// What devices or the operator report; it comes before the phase's own work.
  [[nodiscard]] std::optional<TaskEvent> emergency() const;
  /// Unexpected force that has stopped the arm: somebody pushes, or something is under the object.
  [[nodiscard]] std::optional<TaskEvent> pushed_event() const;
  [[nodiscard]] bool nobody_near_hand() const;
  /// TouchedObject in place of Blocked, where it is that.
  [[nodiscard]] TaskEvent as_touch(TaskEvent event) const;
  [[nodiscard]] bool waits_for_arm() const;
  /// The arm's cycle began anew, or stopped for a late task: what was under way is taken up again.
  void resume_after_restart();
  /// The work of the state's phase in this cycle.
  [[nodiscard]] std::optional<TaskEvent> work();
  void apply(const TaskEvent& event, const JobHooks& hooks);
  /// Begins the phase of the new state.
  void begin_state(Task from, Event event);
  void report(const JobHooks& hooks);
  void report_force(ForceStatus& out) const;
  void ask_partner(const hal::Vec3& place, const JobHooks& hooks);
  /// Lets the devices rest and closes the record.
  [[nodiscard]] RunRecord finish();

  TaskContext c_;

  ArmSupervisor arm_{c_};
  HandSupervisor hand_{c_};
  CameraSupervisor camera_{c_};
  SpeedScaling speed_{c_};
  SeparationSupervisor separation_{c_};
  StallSupervisor stall_{c_};

  PartnerMonitor partner_{c_};
  ObjectMonitor object_{c_};
  LetGoMonitor let_go_{c_, object_};
  LiftEvidence evidence_{c_, object_, let_go_};
  GraspSelector grasps_{c_};
  PartnerRequests requests_{c_};

  ScenePhase scene_phase_{c_, grasps_};
  PartnerPhase partner_phase_{c_, partner_, requests_, grasps_};
  PlanPhase plan_phase_{c_, partner_, requests_, grasps_};
  ApproachPhase approach_phase_{c_, partner_};
  BackOffPhase back_off_phase_{c_, partner_};
  GripPhase grip_phase_{c_, partner_, object_, let_go_};
  TestLiftPhase test_lift_phase_{c_, object_, let_go_, grasps_};
  LiftPhase lift_phase_{c_, object_, let_go_, evidence_};
  PausePhase pause_phase_{c_, object_, let_go_};
  ContactPhase contact_phase_{c_};
  YieldPhase yield_phase_{c_};
  RetreatPhase retreat_phase_{c_, object_, grasps_, scene_phase_, evidence_};

  hal::Timestamp reported_at_{0}, wall_start_{0};
  std::string reason_, detail_;  ///< Why the job is in its state; the event's own words.
  bool refusal_noted_ = false;
  bool interrupted_ = false, lower_confirmed_ = false;  ///< What the operator says in this cycle.
};

}  // namespace colift::control
