#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "control/task/job_status.hpp"
#include "tools/cli/options.hpp"
#include "tools/cli/session.hpp"
#include "tools/rig/back_ends.hpp"
#include "tools/telemetry/channels/channels.hpp"

namespace colift::tools {

class WiredDevices;

// What a run can have beyond the simulated rig. `colift-simulate` is built without it, so that a first lift
// is compiled in minutes; `colift-run` has all of it and is started where one of its options is given.

/// The live view of one run, or of a recording that is played.
class LiveView {
 public:
  virtual ~LiveView() = default;
  [[nodiscard]] virtual telemetry::TelemetrySink& sink() = 0;
  [[nodiscard]] virtual std::string url() const = 0;
  /// An operator pressed stop.
  [[nodiscard]] virtual bool stopped() const = 0;
  /// An operator confirmed since the last call: lowering ...
  [[nodiscard]] virtual bool take_lower_confirmed() = 0;
  /// ... that the arm may continue.
  [[nodiscard]] virtual bool take_continue_confirmed() = 0;
  /// Serves the last state until `enough` says so (it is asked ten times a second).
  virtual void stay(const std::function<bool()>& enough) const = 0;
};

/// A run as topics of ROS 2.
class Ros2View {
 public:
  virtual ~Ros2View() = default;
  [[nodiscard]] virtual telemetry::TelemetrySink& sink() = 0;
  /// Domain and interface, for a person.
  [[nodiscard]] virtual std::string place() const = 0;
  /// Sends what is left, for 1 s at most; what was sent, for a person.
  [[nodiscard]] virtual std::string finish() = 0;
};

/// The recording of one run: file, flight recorder, and whoever else watches. Changes nothing about the run.
class RunRecording {
 public:
  virtual ~RunRecording() = default;
  /// The last call before the job runs.
  [[nodiscard]] virtual control::JobHooks hooks(control::JobHooks yours) = 0;
  virtual void truth(hal::Timestamp at, const TruthSample& sample) = 0;
  /// Closes the files. What was written and what was lost, in lines for a person; `quiet` leaves only what
  /// went wrong. `document` is the run's JSON.
  [[nodiscard]] virtual std::vector<std::string> finish(const control::RunRecord& record,
                                                        const std::string& document, bool quiet) = 0;
};

struct RunParts {
  const WiredDevices* wired = nullptr;  ///< nullptr: no --robot with devices on wires.
  /// Null where no view was asked for. Errors: BadInput for a wrong port or address; NotReady where the port
  /// is taken.
  hal::Result<std::unique_ptr<LiveView>> (*open_view)(const RunOptions& options,
                                                      const std::string& title) = nullptr;
  /// Null where nothing is recorded and nobody watches; the run is left alone then. Errors: files that cannot
  /// be read or made. `watchers`: borrowed.
  hal::Result<std::unique_ptr<RunRecording>> (*open_recording)(
      const CommonOptions& common, const RunOptions& options, const control::JobOptions& job, Rig& rig,
      Setup& setup, const hal::Clock& wall, const std::vector<telemetry::TelemetrySink*>& watchers) = nullptr;
  /// Null where nobody asked for it. Errors: BadInput, BadConfig (domain, interface, or it was not built in),
  /// DeviceFault (Cyclone DDS).
  hal::Result<std::unique_ptr<Ros2View>> (*open_ros2)(const RunOptions& options) = nullptr;
};

/// Everything (library colift_whole_run).
[[nodiscard]] RunParts all_run_parts();

}  // namespace colift::tools
