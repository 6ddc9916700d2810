#pragma once

#include <optional>

#include "control/arm/arm_commander.hpp"
#include "hal/types/result.hpp"
#include "hal/types/time.hpp"
#include "tools/cli/options.hpp"

namespace colift::tools {

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

/// Times as fast as the wall's clock that a run may go: what was asked for; else 1 with a view, or ROS 2, on
/// a simulated rig in lock step, where nobody could follow it otherwise; else 0, as fast as it goes. Errors:
/// BadInput.
[[nodiscard]] hal::Result<double> speed_of(const ViewOptions& options, control::Drive drive,
                                           bool published = false);

}  // namespace colift::tools
