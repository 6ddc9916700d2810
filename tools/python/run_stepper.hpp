#pragma once

#include <unistd.h>

#include <condition_variable>
#include <mutex>
#include <string>
#include <thread>

#include "tools/python/analysis.hpp"
#include "tools/run/run_session.hpp"

namespace colift::python {

/// What a running job says of itself, 30 times a second.
struct Status {
  double t_s = 0.0;  ///< Since the job began.
  std::string state, reason, doing;
  std::optional<double> done, height_m, tilt_rad, slip_m, share_robot;
  std::optional<hal::Vec3> partner;
  double load_n = 0.0, speed_scale = 1.0;
  std::optional<double> distance_m;  ///< Of the nearest person or thing.
};

/// A job in a thread of its own that waits for its caller at each status: one step of the caller is one
/// status of the job. Callables of Python are called from that thread, one at a time and only while somebody
/// steps; what they raise ends the job by a controlled stop and is raised from the last step. The
/// interpreter's lock is held by nobody while the job computes. Methods may be called from any thread that
/// holds it.
///
/// Two locks, taken in this order by whoever needs both: the interpreter's, mutex_. Nobody waits for the
/// interpreter's with mutex_ in hand.
class RunStepper {
 public:
  /// Python callables; None where there is none. `grasps(Analysis) -> candidates`,
  /// `partner(Analysis, seen) -> PartnerGrasp`, `choice(Outcome) -> index or None`,
  /// `carry(sample: dict) -> (speed_scale, lower)`, `lower_confirmed() -> bool`,
  /// `continue_confirmed() -> bool`.
  struct Callables {
    py::object grasps, partner, choice, carry, lower_confirmed, continue_confirmed;
  };

  /// Opens rig and configuration; nothing moves yet. Throws Failure.
  RunStepper(const tools::CommonOptions& common, const tools::RunOptions& options, Callables callables);
  /// As close().
  ~RunStepper();
  RunStepper(const RunStepper&) = delete;
  RunStepper& operator=(const RunStepper&) = delete;

  /// Lets the job go on to its next status; none when it is over. Throws Failure (also NotReady where
  /// another thread, or a callable of this job, steps it at the same time), and what a callable raised.
  [[nodiscard]] std::optional<Status> step();
  /// Asks for a controlled stop; steps go on until the arm is at rest.
  void stop();
  /// Ends the job by a controlled stop, if it is not over, without calling callables any more, and waits for
  /// it.
  void close();
  [[nodiscard]] bool over();
  /// Not after a fork: the job's thread, and what it held or waited for, is the parent's. Such a run cannot
  /// even be destroyed.
  [[nodiscard]] bool of_this_process() const { return ::getpid() == process_; }
  /// The document colift.run/1. Errors: NotReady before the job is over.
  [[nodiscard]] std::string document();
  void write_report(const std::string& file);
  void write_picture(const std::string& file);

 private:
  enum class Turn { Idle, Job, Caller, Over };

  void work();
  [[nodiscard]] control::JobHooks hooks();
  [[nodiscard]] control::JobPolicies policies();
  void wait_for_caller(const Status& status);
  /// Calls Python, with what was raised kept for step(). `otherwise`: the result then.
  template <class T, class Call>
  T guarded(T otherwise, Call call);
  [[nodiscard]] PyAnalysis analysis_of(const control::SceneAnalysis& analysis) const;
  [[nodiscard]] tools::RunView finished();
  void join();

  std::unique_ptr<tools::RunSession> session_;
  Callables callables_;
  std::optional<py::error_already_set> raised_;  ///< With the interpreter's lock only.
  const pid_t process_ = ::getpid();
  std::thread thread_;
  std::mutex joining_;  ///< Only without the interpreter's lock.

  std::mutex mutex_;  ///< Of what follows.
  std::condition_variable changed_;
  Turn turn_ = Turn::Idle;
  bool stepping_ = false;              ///< Somebody waits in step().
  bool stop_ = false, hurry_ = false;  ///< Hurry: nobody steps any more.
  Status status_;
  std::optional<hal::Error> error_;
  std::optional<control::RunRecord> record_;
};

/// Such a job is closed at the interpreter's end at the latest.
void keep_in_mind(const std::shared_ptr<RunStepper>& run);
/// Closes every job that is left; for the interpreter's end, while threads may still take its lock.
void close_all_runs();

}  // namespace colift::python
