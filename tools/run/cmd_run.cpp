#include <fmt/format.h>

#include <unistd.h>

#include <cstdio>

#include "control/task/run_job.hpp"
#include "hal/types/units.hpp"
#include "tools/cli/commands.hpp"
#include "tools/cli/config_of.hpp"
#include "tools/cli/interrupt.hpp"
#include "tools/cli/session.hpp"
#include "tools/recover/stopped_run.hpp"
#include "tools/rig/back_ends.hpp"
#include "tools/run/enter_key.hpp"
#include "tools/run/report/run_report.hpp"
#include "tools/run/run_json.hpp"
#include "tools/run/run_pace.hpp"
#include "tools/run/run_parts.hpp"
#include "tools/run/run_progress.hpp"
#include "tools/run/run_session.hpp"
#include "tools/visualization/file_output.hpp"

namespace colift::tools {
namespace {

/// What makes an arm continue that waits for a confirmation.
std::string way_to_confirm(const EnterKey& key, bool page) {
  if (key.is_there()) return page ? "press Enter, or Continue on the page" : "press Enter to continue";
  if (page) return "press Continue on the page";
  return "nobody can confirm here (that takes a terminal, or --view --allow-operator)";
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
  for (std::size_t n = 0; n < rig.robot.more_cameras.size(); ++n)
    s.devices.push_back({hal::camera_name(n + 1), rig.robot.more_cameras[n]->health(), 0.0});
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
  for (const auto* file : {&options.record, &options.report, &options.png})
    if (*file)
      if (auto ready = picture::prepare_output(**file); !ready) return report_error("run", ready.error());
  auto opened = RunSession::open(common, options, parts.wired);
  if (!opened) return report_error("run", opened.error());
  RunSession& session = **opened;
  Rig& rig = session.rig();
  Setup& setup = session.setup();
  show_warnings("run", common, setup);
  if (options.recover && !rig.simulated)
    return report_error("run", {hal::ErrorCode::BadInput, "--recover",
                                "is for simulated and emulated rigs; here: colift recover, after the stop"});
  const auto speed = speed_of(options.live, rig.drive, options.ros2.on);
  if (!speed) return report_error("run", speed.error());
  hal::Result<std::unique_ptr<LiveView>> live = nullptr;
  if (parts.open_view) live = parts.open_view(options, fmt::format("CoLift, {}", rig.name));
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
    recording =
        parts.open_recording(common, options, session.job(), rig, setup, session.stopwatch(), watchers);
  if (!recording) return report_error("run", recording.error());
  std::optional<RunProgress> progress(std::in_place, stderr,
                                      progress_style(stderr, common.json, common.quiet), session.setting(),
                                      session.stopwatch());
  Pace pace(*speed);
  control::JobHooks watched;
  watched.interrupted = [&] { return InterruptGuard::asked() || (*live && (*live)->stopped()); };
  watched.lower_confirmed = [&] { return *live && (*live)->take_lower_confirmed(); };
  EnterKey enter(STDIN_FILENO);
  watched.continue_confirmed = [&] {
    const bool key = enter.take();
    if (key) progress->line_was_typed();
    return (*live && (*live)->take_continue_confirmed()) || key;
  };
  watched.status = [&](const control::JobStatus& status) {
    if (!InterruptGuard::asked()) pace.wait_for(status.now);
    RunStatus shown = status_of(status, rig);
    if (status.separation.may_confirm)
      shown.press = way_to_confirm(enter, *live && options.live.allow_operator);
    progress->show(shown);
  };
  control::JobHooks hooks = session.hooks(std::move(watched), [&](const TruthSample& sample) {
    if (*recording) (*recording)->truth(rig.robot.clock->now(), sample);
  });
  if (InterruptGuard::asked()) return kInterrupted;  // before any device was started
  const auto record = session.run(*recording ? (*recording)->hooks(hooks) : hooks);
  progress->end();
  progress.reset();
  if (!record) {
    report_error("run", record.error());
    return kDeviceFailed;
  }

  std::string recovery;
  if (options.recover && !record->states.empty() && record->states.back().state == control::Task::Stopped)
    recovery = recover_stopped_run(rig, setup, options.seed, session.began(), common.quiet);

  const RunView run = session.view(*record, recovery);
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
