#include "tools/run/run_session.hpp"

#include <utility>

#include "hal/types/units.hpp"
#include "tools/cli/config_of.hpp"

namespace colift::tools {
namespace {

// of a film: where more would be taken every second one goes, and they are taken half as often
constexpr std::size_t kMaxScenes = 96;
constexpr double kFilmStep_s = 0.2;

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

}  // namespace

hal::Result<std::unique_ptr<RunSession>> RunSession::open(const CommonOptions& common,
                                                          const RunOptions& options,
                                                          const WiredDevices* wired) {
  std::unique_ptr<RunSession> s(new RunSession);
  const auto task = read_task(options.scenario);
  if (!task) return tl::unexpected(task.error());
  auto setup = load_setup(config_of_run(common, options));
  if (!setup) return tl::unexpected(setup.error());
  s->setup_ = std::make_shared<Setup>(std::move(*setup));
  std::optional<hal::Pose> X_WC;
  if (s->setup_->calibration) X_WC = s->setup_->calibration->X_BC();
  auto rig = open_rig({options.robot, options.scenario, options.seed, X_WC, false, options.rig},
                      s->setup_->config, wired);
  if (!rig) return tl::unexpected(rig.error());
  s->rig_ = std::make_unique<Rig>(std::move(*rig));
  s->setting_ = setting_of(common, options, *task, *s->rig_, *s->setup_);
  s->job_ = {s->setup_->method, options.seed, options.dry_run, s->rig_->drive, {}, {}};
  if (s->rig_->truth) {
    s->truth_.mass_kg = s->rig_->truth->mass_kg;
    s->truth_.cog = s->rig_->truth->cog;
  }
  s->began_ = s->rig_->robot.clock->now();
  s->filming_ = s->rig_->truth.has_value() && options.report.has_value();
  s->film_step_s_ = kFilmStep_s;
  return s;
}

void RunSession::film(const control::JobStatus& job) {
  std::vector<FilmScene>& film = scenes_.film;
  if (film.empty() && job.state != control::Task::Approach) return;
  const double t_s = hal::seconds(rig_->robot.clock->now() - began_);
  if (!film.empty() && t_s < film.back().t_s + film_step_s_) return;
  if (film.size() == kMaxScenes) {
    for (std::size_t i = 1; 2 * i < kMaxScenes; ++i) film[i] = std::move(film[2 * i]);
    film.resize(kMaxScenes / 2);
    film_step_s_ *= 2.0;
    return;
  }
  film.push_back({t_s, job.state, rig_->truth->scene()});
}

void RunSession::note_truth(const control::JobStatus& job,
                            const std::function<void(const TruthSample&)>& on_truth) {
  using control::Task;
  const RigTruth& rig = *rig_->truth;
  // he may rest on the object a moment before he bears on it
  const bool decided = job.state == Task::Plan || job.state == Task::Approach;
  if (job.state == Task::Decide || (decided && !truth_.partner)) truth_.partner = rig.partner();
  if (!control::is_loaded(job.state)) return;
  truth_.curve.push_back(rig.sample(began_));
  if (on_truth) on_truth(truth_.curve.back());
}

control::JobHooks RunSession::hooks(control::JobHooks yours,
                                    std::function<void(const TruthSample&)> on_truth) {
  using control::Task;
  const auto mine = std::make_shared<const control::JobHooks>(std::move(yours));
  control::JobHooks hooks = *mine;
  hooks.started = [this, mine] {
    began_ = rig_->robot.clock->now();  // some devices take seconds to start
    if (rig_->begin) rig_->begin();
    if (rig_->truth) rig_->truth->task_state(std::string(control::word(Task::Observe)));
    if (mine->started) mine->started();
  };
  hooks.lower_confirmed = [this, mine] {
    const bool by_caller = mine->lower_confirmed && mine->lower_confirmed();
    return (rig_->truth && rig_->truth->take_lower_confirmed()) || by_caller;
  };
  hooks.continue_confirmed = [this, mine] {
    const bool by_caller = mine->continue_confirmed && mine->continue_confirmed();
    return (rig_->truth && rig_->truth->take_continue_confirmed()) || by_caller;
  };
  hooks.status = [this, mine, on_truth = std::move(on_truth)](const control::JobStatus& status) {
    if (rig_->truth) note_truth(status, on_truth);
    if (filming_) film(status);
    if (mine->status) mine->status(status);
  };
  hooks.asked = [this, mine](const control::PartnerAsk& ask) {
    if (rig_->truth) rig_->truth->ask_partner(ask.grasp_W, ask.aside_W);
    if (mine->asked) mine->asked(ask);
  };
  hooks.changed = [this, mine](Task from, Task to) {
    if (rig_->truth) {
      if (to == Task::AwaitReady || (control::is_end(to) && !scenes_.before))
        scenes_.before = rig_->truth->scene();
      if (from == Task::Hold) scenes_.lifted = rig_->truth->scene();
      rig_->truth->task_state(std::string(control::word(to)));
    }
    if (mine->changed) mine->changed(from, to);
  };
  return hooks;
}

hal::Result<control::RunRecord> RunSession::run(const control::JobHooks& hooks) {
  const control::RigView view{*rig_->model, setup_->hand, setup_->hand_tables, rig_->X_WC, rig_->X_WC_more};
  auto record = control::run_job(rig_->robot, view, setup_->config, job_, hooks, stopwatch_);
  if (record && rig_->truth)
    truth_.verdict = rig_->truth->judge(record->outcome == control::RunRecord::Result::Lifted);
  return record;
}

RunView RunSession::view(const control::RunRecord& record, std::string recovery) {
  if (rig_->arm_link) link_ = rig_->arm_link();
  return {record,
          setting_,
          rig_->truth ? &truth_ : nullptr,
          rig_->truth ? &scenes_ : nullptr,
          link_ ? &*link_ : nullptr,
          std::move(recovery)};
}

}  // namespace colift::tools
