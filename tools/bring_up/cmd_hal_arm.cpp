#include <fmt/format.h>

#include <cmath>
#include <cstdio>
#include <future>

#include "hal/config/config_file.hpp"
#include "hal/drivers/kuka_fri/hand_shake.hpp"
#include "hal/guards/guarded_arm.hpp"
#include "hal/types/units.hpp"
#include "tools/bring_up/bring_up.hpp"
#include "tools/bring_up/bundle/bundle.hpp"
#include "tools/bring_up/hal_arm_json.hpp"
#include "tools/bring_up/hal_arm_obstacles.hpp"
#include "tools/bring_up/hal_arm_task.hpp"
#include "tools/cli/interrupt.hpp"
#include "tools/cli/session.hpp"
#include "tools/rig/rig_world.hpp"

namespace colift::tools {
namespace {

using How = ArmTaskEnd::How;

constexpr double kCareful_deg = 30.0, kCarefulStiffness = 50.0;
constexpr const char* kBundle = "arm-doctor.tar";
constexpr double kLoadSpeed_deg_s = 10.0;
constexpr double kSwitch_s = 2.0;   // in each strategy
constexpr double kTimeout_s = 2.0;  // of a person who waits for command mode
constexpr auto kLook = std::chrono::milliseconds(50);

/// What a call of the command works with.
struct Bench {
  hal::FriConfig fri;
  hal::GuardConfig guard;
  std::shared_ptr<const hal::RobotModel> model;
  control::TaskConfig task;
  control::SetpointLimits setpoints;
};

hal::Result<Bench> load_bench(const CommonOptions& common, const HalOptions& options) {
  const auto config = read_config("hal arm", common);
  if (!config) return tl::unexpected(config.error());
  const auto file = read_wired(options, kWiredArm);
  if (!file) return tl::unexpected(file.error());
  if (file->emulator == "always" && !common.quiet)
    std::fputs(
        "the file's own emulator belongs to \"colift run\"; here \"colift emulate krc\" in another terminal "
        "is the far end\n",
        stderr);
  auto model = read_model(file->model);
  if (!model) return tl::unexpected(model.error());
  return Bench{file->fri, config->guard_arm, std::move(*model), config->task, config->setpoints};
}

hal::Result<ArmTask> move_task(const HalOptions& o, const Bench& bench) {
  const auto bad = [](const char* where, std::string what) {
    return hal::failure(hal::ErrorCode::BadInput, where, std::move(what));
  };
  ArmTask task;
  task.kind = ArmTask::Kind::Move;
  std::string_view name = o.joint;
  if (!name.empty() && (name[0] == 'A' || name[0] == 'a')) name.remove_prefix(1);
  if (name.size() != 1 || name[0] < '1' || name[0] > '7')
    return bad(
        "N",
        fmt::format("\"{}\" is no joint; expected 1 to 7 (KRL calls the third E1, the fourth A3, and so on)",
                    o.joint));
  task.joint = name[0] - '1';
  if (!std::isfinite(o.degrees) || o.degrees == 0.0)
    return bad("DEG", "expected an angle other than 0, in degrees from where the joint stands");
  if (std::abs(o.degrees) > kCareful_deg && !o.yes)
    return bad("DEG", fmt::format("{:+.1f} deg is more than {:.0f}; if the path is free, confirm with --yes",
                                  o.degrees, kCareful_deg));
  if (!std::isfinite(o.speed_deg_s) || o.speed_deg_s <= 0.0)
    return bad("--speed", "expected more than 0 deg/s");
  const double careful = hal::rad_to_deg(kT1Velocity_rad_s);
  const double most =
      hal::rad_to_deg(0.5 * bench.guard.velocity_fraction * bench.model->velocity_rad_s()[task.joint]);
  // what the limits' table prints (one decimal) is granted
  if (o.speed_deg_s > std::ceil(10.0 * careful) / 10.0 && !o.yes)
    return bad("--speed",
               fmt::format("{:.1f} deg/s is more than T1 grants ({:.1f}); in another mode say --yes",
                           o.speed_deg_s, careful));
  if (o.speed_deg_s > most)
    return bad("--speed", fmt::format("{:.1f} deg/s is more than half of what A{} may do ({:.1f})",
                                      o.speed_deg_s, task.joint + 1, most));
  task.by_rad = hal::deg_to_rad(o.degrees);
  task.speed_rad_s = hal::deg_to_rad(o.speed_deg_s);
  return task;
}

hal::Result<ArmTask> task_of(const HalOptions& o, const Bench& bench) {
  if (auto done = check_time(o); !done) return tl::unexpected(done.error());
  ArmTask task;
  if (o.verb == "move-joint") {
    auto move = move_task(o, bench);
    if (!move) return move;
    task = *move;
  } else if (o.verb == "load") {
    if (!o.yes)
      return hal::failure(
          hal::ErrorCode::BadInput, "--yes",
          "the arm will turn A4 to A7 by up to 15 deg both ways about the present pose, ten "
          "times, with 10 deg/s, and come back (about a minute); if the hand is empty and the "
          "path is free, confirm with --yes");
    task.kind = ArmTask::Kind::Load;
    task.speed_rad_s = hal::deg_to_rad(kLoadSpeed_deg_s);
  } else if (o.verb == "state" || o.verb == "doctor") {
    // the KRC's figures are over 100 answers; the KRL program's heartbeat needs a second
    task.for_s = o.for_s.value_or(std::clamp(0.13 * bench.fri.cycle_ms, 1.2, 4.0));
  } else if (o.verb == "watch") {
    if (o.for_s) task.for_s = *o.for_s;
  } else if (o.verb == "switch") {
    task.kind = ArmTask::Kind::Switch;
    task.for_s = o.for_s.value_or(kSwitch_s);
    task.controls = o.controls;
  } else {
    task.kind = ArmTask::Kind::Hold;
    task.for_s = o.for_s.value_or(o.verb == "stiffness" ? 30.0 : 10.0);
  }
  if (o.verb == "stiffness") {
    const double most = std::min(2000.0, bench.guard.max_stiffness_nm_rad);
    if (!std::isfinite(o.stiffness_nm_rad) || o.stiffness_nm_rad < 0.0 || o.stiffness_nm_rad > most)
      return hal::failure(hal::ErrorCode::BadInput, "VALUE",
                          fmt::format("{} N m/rad, expected 0 to {:.0f}", o.stiffness_nm_rad, most));
    if (o.stiffness_nm_rad < kCarefulStiffness && !o.yes)
      return hal::failure(
          hal::ErrorCode::BadInput, "VALUE",
          fmt::format("below {:.0f} N m/rad the arm may sink by what its load data are wrong: hold it, "
                      "and say --yes",
                      kCarefulStiffness));
    task.stiffness_nm_rad = o.stiffness_nm_rad;
  }
  task.control = o.control.empty() ? bench.fri.control : o.control;
  // wrong load data are to be found before an arm stands on springs, where the program lets it
  if (o.verb == "load" && o.control.empty() && hal::script_sets_strategy(bench.fri.script))
    task.control = "position";
  if (o.verb == "load" && task.control == "cartesian_impedance")
    return hal::failure(hal::ErrorCode::BadInput, "--control",
                        "cartesian_impedance: the load is measured in position or joint_impedance");
  if (o.verb == "stiffness" && task.control != "joint_impedance")
    return hal::failure(hal::ErrorCode::BadConfig, "fri.control",
                        fmt::format("{}: this verb commands joint_impedance only", task.control));
  task.config = bench.task;
  task.setpoints = bench.setpoints;
  return task;
}

std::string progress_line(const ArmProgress& p, const ArmTask& task, double at_s) {
  std::string t = fmt::format("{:8.1f} s  {}", at_s, to_string(p.phase));
  if (p.phase != ArmProgress::Phase::Commanding && p.phase != ArmProgress::Phase::Stopping) return t;
  if (task.kind == ArmTask::Kind::Switch) return t;  // its steps are told at the end
  t += task.kind == ArmTask::Kind::Move
           ? fmt::format(" {:3.0f} %, measured minus commanded (deg)", 100 * p.done)
           : std::string(", measured minus commanded (deg)");
  for (std::size_t i = 0; i < p.measured_rad.size(); ++i)
    t += fmt::format(" {:+.3f}", hal::rad_to_deg(p.measured_rad[i] - p.commanded_rad[i]));
  return t;
}

/// Reports progress while the task runs.
class ProgressPrinter {
 public:
  ProgressPrinter(const CommonOptions& common, const HalOptions& options, const ArmTask& task,
                  const hal::RobotModel& model)
      : screen_(progress_screen(common, options, "state")), task_(task), model_(model) {}

  /// The last screen still stands there.
  [[nodiscard]] bool shown() const { return screen_.live(); }

  void show(const ArmView& view, const ArmProgress& p) {
    if (screen_.live() &&
        (p.phase == ArmProgress::Phase::Watching || p.phase == ArmProgress::Phase::Commanding)) {
      std::string text = fmt::format("{}\n{}", arm_screen(view, model_), histogram_text(view.answers));
      if (task_.kind != ArmTask::Kind::Watch)
        text += fmt::format("\n{}\n", progress_line(p, task_, view.at_s));
      screen_.draw(text, view.at_s);
      return;
    }
    if (p.phase != said_) {
      said_ = p.phase;
      if (p.phase != ArmProgress::Phase::Over) screen_.line(progress_line(p, task_, view.at_s));
      return;
    }
    if (p.phase == ArmProgress::Phase::Watching)
      screen_.line_now_and_then(arm_line(view), view.at_s);
    else if (p.phase == ArmProgress::Phase::Commanding)
      screen_.line_now_and_then(progress_line(p, task_, view.at_s), view.at_s);
  }

 private:
  LiveScreen screen_;
  const ArmTask& task_;
  const hal::RobotModel& model_;
  std::optional<ArmProgress::Phase> said_;
};

/// The obstacles that refuse, with what to do; empty when there are none.
std::string refusing(const ArmView& view, const hal::RobotModel& model) {
  std::string text;
  for (const Obstacle& o : obstacles(view, model))
    if (o.refuses) text += fmt::format("  - {}\n    next: {}\n", o.what, o.next);
  return text;
}

/// What to do about an arm that was not there, refused, or went away.
std::string advice(const ArmView& view, const hal::RobotModel& model, const ArmTaskEnd& end) {
  if (end.reason.find("port is in use") != std::string::npos)
    return fmt::format("next: \"ss -lunp sport = :{}\" says who has it; end that one\n", view.config.port);
  if (view.status.received == 0) return fmt::format("next: {}\n", silence_advice(view.config));
  return refusing(view, model);
}

ArmTaskEnd switch_strategies(hal::Arm& guarded, ControlArm& arm, const ArmTask& task, const hal::Clock& clock,
                             const ArmTaskHooks& hooks) {
  const auto asking = [&](bool asks) {
    ArmProgress p;
    p.phase = asks ? ArmProgress::Phase::Asking : ArmProgress::Phase::Commanding;
    hooks.progress.write(p);
  };
  SwitchEnd done =
      run_switch(guarded, arm, task.controls, task.for_s, clock, hooks.interrupted, asking, hooks.why);
  ArmTaskEnd end;
  const bool commanded = !done.steps.empty() && done.steps.back().reached;
  end.how = done.interrupted      ? How::Interrupted
            : done.reason.empty() ? How::Done
            : commanded           ? How::Lost
                                  : How::Refused;
  end.reason = done.interrupted ? "asked to end" : done.reason;
  for (const SwitchStep& step : done.steps) end.commanded = end.commanded || step.reached;
  end.switches = std::move(done.steps);
  return end;
}

/// One call: the cycle in a thread of its own, words and interrupts in this one.
int run(const CommonOptions& common, const HalOptions& options, const Bench& bench, const ArmTask& task) {
  const hal::SteadyClock clock;
  auto made = hal::make_fri_arm(bench.fri, clock);
  if (!made) return report_error("hal arm", made.error());
  hal::FriArm& fri = **made;
  auto controlled = std::make_unique<ControlArm>(std::move(*made), *bench.model);
  ControlArm& strategies = *controlled;
  strategies.use(task.control);
  std::unique_ptr<hal::Arm> arm = std::move(controlled);
  if (task.kind != ArmTask::Kind::Watch)
    arm = std::make_unique<hal::GuardedArm>(std::move(arm), *bench.model, bench.guard);

  const InterruptGuard signals;
  std::atomic<bool> interrupted{false};
  hal::LatestValue<ArmProgress> progress;
  std::promise<hal::RealtimeReport> granted;
  std::future<hal::RealtimeReport> grant = granted.get_future();
  const hal::Timestamp began = clock.now();
  const auto at_s = [&] { return hal::seconds(clock.now() - began); };
  std::future<ArmTaskEnd> work = std::async(std::launch::async, [&] {
    granted.set_value(hal::ask_for_realtime({}));
    const ArmTaskHooks hooks{interrupted, progress, [&] { return why_not(fri.status(), fri.config()); }};
    if (task.kind == ArmTask::Kind::Switch) return switch_strategies(*arm, strategies, task, clock, hooks);
    return run_arm_task(*arm, *bench.model, bench.guard, task, clock, hooks);
  });
  const hal::RealtimeReport realtime = grant.get();
  if (!common.quiet)
    for (const std::string& words : realtime.words) std::fprintf(stderr, "%s\n", words.c_str());

  ProgramMonitor program;
  ProgressPrinter printer(common, options, task, *bench.model);
  std::optional<double> asking_since_s;
  bool printed_why = false, printed_remarks = task.kind == ArmTask::Kind::Watch || common.quiet;
  while (work.wait_for(kLook) != std::future_status::ready) {
    const ArmProgress p = progress.read();
    if (InterruptGuard::asked()) {
      interrupted = true;
      if (p.phase == ArmProgress::Phase::Asking) arm->stop();  // activate() waits for the KRC
    }
    if (fri.status().received > 0) program.note(fri.measurement(), at_s());
    const ArmView view = view_of(fri, program, realtime, bench.guard.limit_margin_deg, at_s());
    printer.show(view, p);
    if (!printed_remarks && p.phase >= ArmProgress::Phase::Asking && view.status.received > 0) {
      printed_remarks = true;
      for (const Obstacle& o : obstacles(view, *bench.model))
        if (o.kind == std::string_view("unexplained-load") || o.kind == std::string_view("torque-sign") ||
            o.kind == std::string_view("krc-address"))
          std::fputs(fmt::format("{}\nnext: {}\n", o.what, o.next).c_str(), stderr);
    }
    if (p.phase != ArmProgress::Phase::Asking) continue;
    if (!asking_since_s) asking_since_s = at_s();
    if (printed_why || common.quiet || at_s() - *asking_since_s < kTimeout_s) continue;
    printed_why = true;
    if (const std::string text = refusing(view, *bench.model); !text.empty())
      std::fputs(fmt::format("command mode does not come:\n{}", text).c_str(), stderr);
  }
  const ArmTaskEnd end = work.get();
  const ArmView view = view_of(fri, program, realtime, bench.guard.limit_margin_deg, at_s());

  if (options.verb == "doctor") {
    const std::filesystem::path out = options.out.value_or(kBundle);
    hal::FriConfig fri_config = bench.fri;
    std::string machine;
    for (const std::string& words : realtime.words) machine += words + "\n";
    const std::string why = end.reason.empty() ? std::string() : end.reason + "\n";
    const auto written = write_bundle(
        out,
        {{"state.txt", arm_screen(view, *bench.model)},
         {"answers.txt", histogram_text(view.answers)},
         {"obstacles.txt", why + (view.status.received > 0 ? obstacles_text(obstacles(view, *bench.model))
                                                           : advice(view, *bench.model, end))},
         {"state.json", arm_document(options.verb, view, *bench.model, task, end) + "\n"},
         {"machine.txt", machine},
         {"config.yaml", hal::effective_yaml(hal::table_of(fri_config), false)}});
    if (!written) return report_error("hal arm doctor", written.error());
    std::fprintf(stderr, "%s: state, answer times, what prevents command mode, settings: send this file\n",
                 out.c_str());
  }
  if (common.json) {
    std::puts(arm_document(options.verb, view, *bench.model, task, end).c_str());
  } else if (view.status.received > 0) {
    std::string text;
    if (task.kind != ArmTask::Kind::Watch)
      text = task_summary(task, end);
    else if (options.verb == "state" || (!common.quiet && !printer.shown()))
      text = arm_screen(view, *bench.model);
    if (options.verb == "watch" && !printer.shown())
      text += fmt::format("\n{}", histogram_text(view.answers));
    std::fputs(text.c_str(), stdout);
  }
  std::fflush(stdout);
  if (end.how != How::Done && end.how != How::Interrupted)
    report_failure(
        "arm", options.verb, end.reason,
        exit_code(end.how) == kDeviceFailed ? std::optional(advice(view, *bench.model, end)) : std::nullopt);
  if (end.how == How::Done && view.status.session == hal::FriSession::Silent) {
    std::fprintf(stderr, "colift hal arm %s: %s\n", options.verb.c_str(),
                 why_not(view.status, view.config).c_str());
    return kDeviceFailed;
  }
  return exit_code(end.how);
}

}  // namespace

int cmd_hal_arm(const CommonOptions& common, const HalOptions& options) {
  const auto bench = load_bench(common, options);
  if (!bench) return report_error("hal arm", bench.error());
  if (options.verb == "limits") {
    if (common.json)
      std::puts(limits_document(*bench->model, bench->guard).c_str());
    else
      std::fputs(limits_table(*bench->model, bench->guard).c_str(), stdout);
    return kDone;
  }
  if (options.verb == "doctor")
    if (auto free = check_new_bundle(options.out.value_or(kBundle)); !free)
      return report_error("hal arm doctor", free.error());
  const auto task = task_of(options, *bench);
  if (!task) return report_error(("hal arm " + options.verb).c_str(), task.error());
  return run(common, options, *bench, *task);
}

}  // namespace colift::tools
