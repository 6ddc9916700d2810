#pragma once

#include <functional>
#include <memory>
#include <string>

#include "control/task/run_job.hpp"
#include "tools/cli/options.hpp"
#include "tools/cli/session.hpp"
#include "tools/rig/back_ends.hpp"
#include "tools/run/run_view.hpp"

namespace colift::tools {

/// One run of the job and everything that belongs to it: rig, configuration, and what a simulated rig knows
/// of the truth. `colift run` and the Python module are two faces of it. One job; one thread.
class RunSession {
 public:
  /// Errors: BadConfig, BadInput with the place; what the devices say.
  [[nodiscard]] static hal::Result<std::unique_ptr<RunSession>> open(const CommonOptions& common,
                                                                     const RunOptions& options,
                                                                     const WiredDevices* wired);

  [[nodiscard]] Rig& rig() { return *rig_; }
  [[nodiscard]] Setup& setup() { return *setup_; }
  [[nodiscard]] std::shared_ptr<const Setup> shared_setup() const { return setup_; }
  [[nodiscard]] const RunSetting& setting() const { return setting_; }
  [[nodiscard]] control::JobOptions& job() { return job_; }
  [[nodiscard]] const hal::Clock& stopwatch() const { return stopwatch_; }
  /// When the job began (robot's clock).
  [[nodiscard]] hal::Timestamp began() const { return began_; }

  /// `yours`, called after what the rig's scenario and its truth need. `on_truth` gets each true sample of
  /// the lift; may be empty.
  [[nodiscard]] control::JobHooks hooks(control::JobHooks yours,
                                        std::function<void(const TruthSample&)> on_truth = {});
  /// Does the job with such hooks, once. Errors: as run_job().
  [[nodiscard]] hal::Result<control::RunRecord> run(const control::JobHooks& hooks);

  /// What screen, JSON and report show of it. Borrows record and session; `recovery`: document of the
  /// recovery after it.
  [[nodiscard]] RunView view(const control::RunRecord& record, std::string recovery = {});

 private:
  RunSession() = default;
  void film(const control::JobStatus& job);
  void note_truth(const control::JobStatus& job, const std::function<void(const TruthSample&)>& on_truth);

  std::shared_ptr<Setup> setup_;
  std::unique_ptr<Rig> rig_;
  RunSetting setting_;
  control::JobOptions job_;
  hal::SteadyClock stopwatch_;
  hal::Timestamp began_{0};
  RunTruth truth_;
  RunScenes scenes_;
  bool filming_ = false;
  double film_step_s_ = 0.0;  ///< Between two scenes of the film.
  std::optional<ArmLink> link_;
};

}  // namespace colift::tools
