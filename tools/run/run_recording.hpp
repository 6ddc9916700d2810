#pragma once

#include <memory>
#include <optional>
#include <string>

#include "control/task/task_runner.hpp"
#include "tools/cli/options.hpp"
#include "tools/cli/session.hpp"
#include "tools/rig/back_ends.hpp"
#include "tools/run/run_view.hpp"
#include "tools/telemetry/channels/channels.hpp"

namespace colift::tools {

/// The recording of one run: file, flight recorder, and whoever else watches. Changes nothing about the run.
class RunRecording {
 public:
  /// What was asked for. None of it: null, and the run is left alone. Errors: files that cannot be read or
  /// made.
  struct Request {
    std::vector<telemetry::TelemetrySink*> watchers;  ///< Live view; borrowed.
  };
  [[nodiscard]] static hal::Result<std::unique_ptr<RunRecording>> open(
      const CommonOptions& common, const RunOptions& options, const control::JobOptions& job, Rig& rig,
      Setup& setup, const hal::Clock& wall, const Request& request);
  ~RunRecording();
  RunRecording(const RunRecording&) = delete;
  RunRecording& operator=(const RunRecording&) = delete;

  /// The last call before the job runs.
  [[nodiscard]] control::JobHooks hooks(control::JobHooks yours);
  void truth(hal::Timestamp at, const TruthSample& sample);
  /// Closes the files. What was written and what was lost, in lines for a person; `quiet` leaves only what
  /// went wrong. `document` is the run's JSON.
  [[nodiscard]] std::vector<std::string> finish(const control::RunRecord& record, const std::string& document,
                                                bool quiet);

 private:
  struct Impl;
  explicit RunRecording(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace colift::tools
