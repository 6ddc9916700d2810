#include <fmt/format.h>

#include <cstdio>

#include "control/task/run_job.hpp"
#include "hal/types/units.hpp"
#include "tools/cli/commands.hpp"
#include "tools/cli/config_of.hpp"
#include "tools/cli/interrupt.hpp"
#include "tools/cli/session.hpp"
#include "tools/recover/stopped_run.hpp"
#include "tools/rig/back_ends.hpp"
#include "tools/run/run_json.hpp"
#include "tools/run/run_pace.hpp"
#include "tools/run/run_parts.hpp"
#include "tools/run/run_progress.hpp"
#include "tools/run/run_report.hpp"

namespace colift::tools {
namespace {

RunSetting setting_of(const CommonOptions& common, const RunOptions& options, const RunTask& task,
                      const Rig& rig, const control::ResolvedConfig& resolved) {
  const control::Config& config = resolved.config;
  RunSetting s;
  s.scenario = rig.truth ? task.scenario : "";
  s.robot = rig.name;
  s.method = control::to_string(resolved.method);
  s.seed = options.seed;
  s.share = config.decision.share;
  s.command = common.command;
  s.simulated = rig.truth.has_value();
  s.dry_run = options.dry_run;
  s.X_WC = rig.X_WC;
  s.model = rig.model.get();
  s.home_rad = rig.home_rad;
  for (const std::string& file : common.config_files) s.config.emplace_back(file, "--config");
  for (const std::string& setting : common.settings) s.config.emplace_back(setting, "--set");
  s.lift_height_m = config.task.lift_height_m;
  s.hold_s = config.task.hold_s;
  s.max_tilt_rad = hal::deg_to_rad(config.task.max_tilt_deg);
  s.max_slip_m = config.task.max_slip_m;
  return s;
}

RunStatus status_of(const control::JobStatus& job, const Rig& rig) {
  RunStatus s;
  s.t_s = hal::seconds(job.now);
  s.state = job.state;
  s.in_state_s = hal::seconds(job.now - job.since);
  s.reason = job.reason;
  s.now = job.doing;
  s.done = job.done;
  s.devices = {{"arm", rig.robot.arm->health(), 0.0},
               {"hand", rig.robot.hand->health(), 0.0},
               {"camera", rig.robot.camera->health(), 0.0}};
  s.partner = job.partner_W;
  s.partner_note = job.partner_note;
  if (const auto& outcome = job.record->decision; outcome && outcome->decision.chosen) {
    s.candidate = outcome->candidates[*outcome->decision.chosen].id;
    s.share_predicted = outcome->decision.share;
  }
  if (control::is_loaded(job.state)) s.load_n = job.load_n;
  s.height_m = job.height_m;
  s.tilt_rad = job.tilt_rad;
  s.slip_m = job.slip_m;
  for (const auto& fault : job.record->faults) s.faults.push_back(fault.device + ": " + fault.what);
  return s;
}

/// What a simulated run knows of the truth, collected while it goes on.
struct TruthLog {
  RunTruth truth;
  RunScenes scenes;

  void on_status(const control::JobStatus& job, const RigTruth& rig, hal::Timestamp began) {
    using control::Task;
    // he may rest on the object a moment before he bears on it
    const bool decided = job.state == Task::Plan || job.state == Task::Approach;
    if (job.state == Task::Decide || (decided && !truth.partner)) truth.partner = rig.partner();
    if (control::is_loaded(job.state)) truth.curve.push_back(rig.sample(began));
  }
  void on_change(control::Task from, control::Task to, const RigTruth& rig) {
    using control::Task;
    if (to == Task::AwaitReady || (control::is_end(to) && !scenes.before)) scenes.before = rig.scene();
    if (from == Task::Hold) scenes.lifted = rig.scene();
  }
};

int exit_code(const control::RunRecord& record, const RunOptions& options) {
  if (InterruptGuard::asked()) return kInterrupted;
  if (record.outcome == control::RunRecord::Result::Lifted) return kDone;
  if (record.device_failed) return kDeviceFailed;
  if (options.dry_run && record.plan) return kDone;
  return kNoGoal;
}

}  // namespace

int cmd_run(const CommonOptions& common, const RunOptions& options, const RunParts& parts) {
  const InterruptGuard signals;
  const auto task = read_task(options.scenario);
  if (!task) return report_error("run", task.error());
  auto setup = load_setup(config_of_run(common, options));
  if (!setup) return report_error("run", setup.error());
  show_warnings("run", common, *setup);
  std::optional<hal::Pose> X_WC;
  if (setup->calibration) X_WC = setup->calibration->X_BC();
  auto rig = open_rig({options.robot, options.scenario, options.seed, X_WC, false, options.rig},
                      setup->config, parts.wired);
  if (!rig) return report_error("run", rig.error());
  if (options.recover && !rig->simulated)
    return report_error("run", {hal::ErrorCode::BadInput, "--recover",
                                "is for simulated and emulated rigs; here: colift recover, after the stop"});

  const RunSetting setting = setting_of(common, options, *task, *rig, *setup);
  const hal::SteadyClock wall;
  TruthLog truth_log;
  if (rig->truth) {
    truth_log.truth.mass_kg = rig->truth->mass_kg;
    truth_log.truth.cog = rig->truth->cog;
  }
  control::JobOptions job{setup->method, options.seed, options.dry_run, rig->drive};
  const auto speed = speed_of(options.live, rig->drive, options.ros2.on);
  if (!speed) return report_error("run", speed.error());
  hal::Result<std::unique_ptr<LiveView>> live = nullptr;
  if (parts.open_view) live = parts.open_view(options, fmt::format("CoLift, {}", rig->name));
  if (!live) return report_error("run", live.error());
  std::vector<telemetry::TelemetrySink*> watchers;
  if (*live) {
    watchers.push_back(&(*live)->sink());
    std::fprintf(stderr, "live view: %s\n", (*live)->url().c_str());
  }
  hal::Result<std::unique_ptr<Ros2View>> ros2 = nullptr;
  if (parts.open_ros2) ros2 = parts.open_ros2(options);
  if (!ros2) return report_error("run", ros2.error());
  if (*ros2) {
    watchers.push_back(&(*ros2)->sink());
    if (!common.quiet) std::fprintf(stderr, "ROS 2: %s\n", (*ros2)->place().c_str());
  }
  hal::Result<std::unique_ptr<RunRecording>> recording = nullptr;
  if (parts.open_recording)
    recording = parts.open_recording(common, options, job, *rig, *setup, wall, watchers);
  if (!recording) return report_error("run", recording.error());
  const control::RigView view{*rig->model, setup->hand, setup->hand_tables, rig->X_WC};

  std::optional<RunProgress> progress(std::in_place, stderr,
                                      progress_style(stderr, common.json, common.quiet), setting, wall);
  hal::Timestamp began = rig->robot.clock->now();
  control::JobHooks hooks;
  hooks.started = [&] {
    began = rig->robot.clock->now();  // some devices take seconds to start
    if (rig->begin) rig->begin();
    if (rig->truth) rig->truth->task_state(std::string(control::word(control::Task::Observe)));
  };
  hooks.interrupted = [&] { return InterruptGuard::asked() || (*live && (*live)->stopped()); };
  hooks.lower_confirmed = [&] {
    const bool by_operator = *live && (*live)->take_lower_confirmed();
    return (rig->truth && rig->truth->take_lower_confirmed()) || by_operator;
  };
  Pace pace(*speed);
  hooks.status = [&](const control::JobStatus& status) {
    if (!InterruptGuard::asked()) pace.wait_for(status.now);
    if (rig->truth) {
      const std::size_t samples = truth_log.truth.curve.size();
      truth_log.on_status(status, *rig->truth, began);
      if (*recording && truth_log.truth.curve.size() > samples)
        (*recording)->truth(rig->robot.clock->now(), truth_log.truth.curve.back());
    }
    progress->show(status_of(status, *rig));
  };
  hooks.asked = [&](const hal::Vec3& place) {
    if (rig->truth) rig->truth->ask_partner(place);
  };
  hooks.changed = [&](control::Task from, control::Task to) {
    if (!rig->truth) return;
    truth_log.on_change(from, to, *rig->truth);
    rig->truth->task_state(std::string(control::word(to)));
  };
  if (InterruptGuard::asked()) return kInterrupted;  // before any device was started
  const auto record = control::run_job(rig->robot, view, setup->config, job,
                                       *recording ? (*recording)->hooks(hooks) : hooks, wall);
  progress->end();
  progress.reset();
  if (!record) {
    report_error("run", record.error());
    return kDeviceFailed;
  }

  if (rig->truth)
    truth_log.truth.verdict = rig->truth->judge(record->outcome == control::RunRecord::Result::Lifted);

  std::string recovery;
  if (options.recover && !record->states.empty() && record->states.back().state == control::Task::Stopped)
    recovery = recover_stopped_run(*rig, *setup, options.seed, began, common.quiet);

  std::optional<ArmLink> link;
  if (rig->arm_link) link = rig->arm_link();
  const RunView run{*record,
                    setting,
                    rig->truth ? &truth_log.truth : nullptr,
                    rig->truth ? &truth_log.scenes : nullptr,
                    link ? &*link : nullptr,
                    recovery};
  const std::string document = run_document(run);
  if (*recording)
    for (const std::string& line : (*recording)->finish(*record, document, common.quiet))
      std::fprintf(stderr, "%s\n", line.c_str());
  if (*ros2) {
    const std::string sent = (*ros2)->finish();
    if (!common.quiet) std::fprintf(stderr, "%s\n", sent.c_str());
  }
  const int ended_with = exit_code(*record, options);  // before Ctrl-C may mean the view
  if (common.json)
    std::puts(document.c_str());
  else
    std::fputs((common.quiet ? record->reason + "\n" : run_summary(run)).c_str(), stdout);
  std::fflush(stdout);
  if (options.report) {
    if (auto written = write_run_report(*options.report, run); !written)
      return report_error("run", written.error());
    if (!common.quiet) std::fprintf(stderr, "report: %s\n", options.report->c_str());
  }
  if (options.png) {
    if (auto written = write_lift_picture(*options.png, run); !written)
      return report_error("run", written.error());
  }
  if (*live && !InterruptGuard::asked()) {
    std::fprintf(stderr, "the live view keeps the last state at %s; Ctrl-C ends it\n",
                 (*live)->url().c_str());
    (*live)->stay(InterruptGuard::asked);
    return (*live)->stopped() ? kInterrupted : ended_with;
  }
  return ended_with;
}

}  // namespace colift::tools
