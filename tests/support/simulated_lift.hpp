#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "control/config.hpp"
#include "control/run_record.hpp"
#include "sim_hal/scenario/scenario.hpp"

namespace colift::tests {

/// One whole job on the simulated rig, and how good it truly was.
struct SimulatedLift {
  control::RunRecord record;
  double tilt_deg = NAN;     ///< True, mean at the top.
  double height_m = NAN;     ///< Of the centre of gravity, mean at the top.
  double share_robot = NAN;  ///< The robot's true part of the vertical force at the top.
  double slip_m = NAN;
  double partner_error_m = NAN;  ///< Of the seen grasp.
  bool hit_something = false;
};

[[nodiscard]] SimulatedLift simulate(const sim_hal::Scenario& scenario, control::Method method,
                                     std::uint64_t seed, control::Config config = control::run_defaults());

/// Value below which the part `p` of the numbers lies; NaN of none.
[[nodiscard]] double quantile(std::vector<double> values, double p);

}  // namespace colift::tests
