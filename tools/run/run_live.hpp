#pragma once

#include <atomic>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "control/arm/arm_commander.hpp"
#include "hal/types/result.hpp"
#include "hal/types/time.hpp"
#include "tools/cli/options.hpp"
#include "tools/live/live_server.hpp"

namespace colift::tools {

/// The live view of one run, or of a recording that is played: the server, and who may do what there.
class RunLive {
 public:
  /// Null where no view was asked for. Errors: BadInput for a wrong port or address; NotReady where the port
  /// is taken.
  /// `urdf` is the robot's description for the page.
  [[nodiscard]] static hal::Result<std::unique_ptr<RunLive>> open(const ViewOptions& options,
                                                                  const std::string& title, std::string urdf);

  [[nodiscard]] telemetry::TelemetrySink& sink() { return *server_; }
  [[nodiscard]] std::string url() const { return server_->url(); }
  /// An operator pressed stop.
  [[nodiscard]] bool stopped() const { return stopped_; }
  /// Serves the last state until `enough` says so (it is asked ten times a second).
  void stay(const std::function<bool()>& enough) const;

 private:
  RunLive() = default;
  std::atomic<bool> stopped_{false};
  std::unique_ptr<live::LiveServer> server_;
};

/// The description of the robot that a robot file names; the built-in one where it names none.
[[nodiscard]] hal::Result<std::string> robot_urdf(const std::optional<std::filesystem::path>& robot_file);

/// Keeps a simulated run from being over before somebody saw it: its time goes no faster than `speed` times
/// the wall's. Waiting changes nothing about the run.
class Pace {
 public:
  /// 0: as fast as it goes.
  explicit Pace(double speed) : speed_(speed) {}
  void wait_for(hal::Timestamp simulated);

 private:
  double speed_;
  std::optional<hal::Timestamp> simulated_start_, wall_start_;
};

/// Times as fast as the wall's clock that a run may go: what was asked for; else 1 with a view on a simulated
/// rig in lock step, where nobody could follow it otherwise; else 0, as fast as it goes. Errors: BadInput.
[[nodiscard]] hal::Result<double> speed_of(const ViewOptions& options, control::Drive drive);

}  // namespace colift::tools
