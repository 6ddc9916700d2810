#pragma once

#include <cmath>
#include <cstdint>

#include "control/config/config.hpp"
#include "control/task/run_record.hpp"
#include "hal/types/result.hpp"
#include "sim_hal/scenario/scenario.hpp"

namespace colift::experiments {

/// One whole job on the simulated rig, as `colift run` does it, and how good it truly was.
struct WholeLift {
  control::RunRecord record;
  double tilt_deg = NAN, height_m = NAN, share_robot = NAN;  ///< True, means at the top.
  double slip_m = NAN;
  bool hit_something = false;
};

/// Errors: BadConfig (the scenario), and those of devices at the start.
[[nodiscard]] hal::Result<WholeLift> run_whole_lift(const sim_hal::Scenario& scenario, control::Method method,
                                                    std::uint64_t seed);

}  // namespace colift::experiments
