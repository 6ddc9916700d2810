#include "tools/python/run_stepper.hpp"

#include <list>

#include "tools/run/report/run_report.hpp"
#include "tools/run/run_json.hpp"

namespace colift::python {
namespace {

Status status_of(const control::JobStatus& job, hal::Timestamp began) {
  Status s;
  s.t_s = hal::seconds(job.now - began);
  s.state = control::word(job.state);
  s.reason = job.reason;
  s.doing = job.doing;
  s.done = job.done;
  s.partner = job.partner_W;
  s.height_m = job.height_m;
  s.tilt_rad = job.tilt_rad;
  s.slip_m = job.slip_m;
  s.share_robot = job.share_robot;
  s.load_n = control::is_loaded(job.state) ? job.load_n : 0.0;
  s.speed_scale = job.separation.scale;
  s.distance_m = job.separation.distance_m;
  return s;
}

py::dict dict_of(const control::LiftSample& sample) {
  py::dict d;
  d["t_s"] = sample.t_s;
  d["state"] = std::string(control::word(sample.state));
  d["palm_height_m"] = sample.palm_height_m;
  d["object_rise_m"] = sample.object_rise_m;
  d["tilt_rad"] = sample.tilt_rad;
  d["slip_m"] = sample.slip_m;
  d["load_n"] = sample.load_n;
  d["force_W"] = hal::Vec3(sample.wrench_W.force);
  d["torque_W"] = hal::Vec3(sample.wrench_W.torque);
  d["palm_W"] = hal::Vec3(sample.palm_W);
  return d;
}

// With the interpreter's lock only.
std::list<std::weak_ptr<RunStepper>>& running() {
  static auto* const all = new std::list<std::weak_ptr<RunStepper>>();  // outlives everything
  return *all;
}

}  // namespace

void keep_in_mind(const std::shared_ptr<RunStepper>& run) {
  running().remove_if([](const auto& other) { return other.expired(); });
  running().push_back(run);
}

void close_all_runs() {
  while (!running().empty()) {
    const auto run = running().front().lock();
    running().pop_front();
    if (run) run->close();
  }
}

RunStepper::RunStepper(const tools::CommonOptions& common, const tools::RunOptions& options,
                       Callables callables)
    : callables_(std::move(callables)) {
  {
    const Unlocked other_threads_run;
    session_ = value_of(tools::RunSession::open(common, options, nullptr));
  }
  session_->job().policies = policies();
}

RunStepper::~RunStepper() {
  close();
}

void RunStepper::close() {
  if (!of_this_process()) return;
  {
    const py::gil_scoped_release callables_end;
    {
      const std::lock_guard lock(mutex_);
      stop_ = hurry_ = true;
      if (turn_ == Turn::Idle) turn_ = Turn::Over;
      if (turn_ == Turn::Caller) turn_ = Turn::Job;
    }
    changed_.notify_all();
    join();
  }
  callables_ = {};
}

void RunStepper::join() {
  const std::lock_guard alone(joining_);
  if (thread_.joinable()) thread_.join();
}

template <class T, class Call>
T RunStepper::guarded(T otherwise, Call call) {
  {
    const std::lock_guard lock(mutex_);
    if (hurry_) return otherwise;
  }
  const py::gil_scoped_acquire in_python;
  if (raised_) return otherwise;
  try {
    return call();
  } catch (py::error_already_set& e) {
    raised_.emplace(e);
  } catch (const py::cast_error&) {
    PyErr_SetString(PyExc_TypeError,
                    "a callable of this run returned a value of another type than its description says");
    raised_.emplace();
  } catch (const std::exception& e) {
    PyErr_SetString(PyExc_RuntimeError, e.what());
    raised_.emplace();
  }
  stop();
  return otherwise;
}

PyAnalysis RunStepper::analysis_of(const control::SceneAnalysis& analysis) const {
  auto seen = std::make_shared<tools::Seen>();
  seen->analysis = analysis;
  seen->file.points = analysis.frame.depth_m.size();
  seen->file.valid_points = analysis.frame.depth_m.size();
  seen->file.note = "a frame of the run";
  return {session_->shared_setup(), std::move(seen)};
}

control::JobPolicies RunStepper::policies() {
  control::JobPolicies p;
  if (!callables_.grasps.is_none())
    p.grasps = [this](const control::SceneAnalysis& analysis) {
      return guarded(analysis.candidates, [&] {
        return callables_.grasps(analysis_of(analysis)).cast<std::vector<planner::GraspCandidate>>();
      });
    };
  if (!callables_.partner.is_none())
    p.partner = [this](const control::SceneAnalysis& analysis, const perception::PartnerGrasp& seen) {
      return guarded(seen, [&] {
        return callables_.partner(analysis_of(analysis), seen).cast<perception::PartnerGrasp>();
      });
    };
  if (!callables_.choice.is_none())
    p.choice = [this](const control::SceneAnalysis& analysis, const control::Outcome& outcome) {
      return guarded(std::optional<std::size_t>(), [&] {
        const PyAnalysis a = analysis_of(analysis);
        return callables_.choice(PyOutcome{a.setup, a.seen, outcome}).cast<std::optional<std::size_t>>();
      });
    };
  if (!callables_.carry.is_none())
    p.carry = [this](const control::LiftSample& sample) {
      return guarded(control::CarryOrder{}, [&] {
        const auto [scale, lower] = callables_.carry(dict_of(sample)).cast<std::pair<double, bool>>();
        return control::CarryOrder{scale, lower};
      });
    };
  return p;
}

void RunStepper::wait_for_caller(const Status& status) {
  std::unique_lock lock(mutex_);
  if (hurry_) return;
  status_ = status;
  turn_ = Turn::Caller;
  changed_.notify_all();
  changed_.wait(lock, [&] { return turn_ == Turn::Job; });
}

control::JobHooks RunStepper::hooks() {
  control::JobHooks hooks;
  hooks.interrupted = [this] {
    const std::lock_guard lock(mutex_);
    return stop_;
  };
  if (!callables_.lower_confirmed.is_none())
    hooks.lower_confirmed = [this] {
      return guarded(false, [&] { return callables_.lower_confirmed().cast<bool>(); });
    };
  if (!callables_.continue_confirmed.is_none())
    hooks.continue_confirmed = [this] {
      return guarded(false, [&] { return callables_.continue_confirmed().cast<bool>(); });
    };
  hooks.status = [this](const control::JobStatus& job) {
    wait_for_caller(status_of(job, session_->began()));
  };
  return session_->hooks(std::move(hooks));
}

void RunStepper::work() {
  hal::Result<control::RunRecord> record = hal::failure(hal::ErrorCode::DeviceFault, "run", "");
  try {
    record = session_->run(hooks());
  } catch (const std::exception& e) {  // such as memory that ran out
    record = hal::failure(hal::ErrorCode::DeviceFault, "run", e.what());
  }
  const std::lock_guard lock(mutex_);
  if (record)
    record_ = std::move(*record);
  else
    error_ = record.error();
  turn_ = Turn::Over;
  changed_.notify_all();
}

std::optional<Status> RunStepper::step() {
  if (!of_this_process())
    throw Failure{{hal::ErrorCode::NotReady, "run.step", "it belongs to the process that was forked"}};
  std::optional<Status> status;
  std::optional<hal::Error> error;
  {
    const Unlocked job_runs;
    std::unique_lock lock(mutex_);
    if (stepping_)
      throw Failure{{hal::ErrorCode::NotReady, "run.step",
                     "another thread, or a callable of this run, is inside of a step already"}};
    if (turn_ == Turn::Idle) {
      thread_ = std::thread([this] { work(); });
      turn_ = Turn::Job;
    } else if (turn_ == Turn::Caller) {
      turn_ = Turn::Job;
      changed_.notify_all();
    }
    stepping_ = true;
    changed_.wait(lock, [&] { return turn_ == Turn::Caller || turn_ == Turn::Over; });
    stepping_ = false;
    if (turn_ == Turn::Caller) status = status_;
    error = error_;
    lock.unlock();
    if (!status) join();
  }
  if (status) return status;
  callables_ = {};
  if (raised_) {
    const py::error_already_set raised = *raised_;
    raised_.reset();
    throw py::error_already_set(raised);
  }
  if (error) throw Failure{*error};
  return std::nullopt;
}

void RunStepper::stop() {
  const std::lock_guard lock(mutex_);
  stop_ = true;
}

bool RunStepper::over() {
  const std::lock_guard lock(mutex_);
  return turn_ == Turn::Over;
}

tools::RunView RunStepper::finished() {
  const std::lock_guard lock(mutex_);
  if (error_) throw Failure{*error_};
  if (!record_)
    throw Failure{{hal::ErrorCode::NotReady, "run",
                   turn_ == Turn::Over ? "it was closed before it began"
                                       : "the job is not over: step() until it returns None"}};
  return session_->view(*record_);
}

std::string RunStepper::document() {
  return tools::run_document(finished());
}

void RunStepper::write_report(const std::string& file) {
  const tools::RunView view = finished();
  const Unlocked other_threads_run;
  value_of(tools::write_run_report(file, view));
}

void RunStepper::write_picture(const std::string& file) {
  const tools::RunView view = finished();
  const Unlocked other_threads_run;
  value_of(tools::write_lift_picture(file, view));
}

}  // namespace colift::python
