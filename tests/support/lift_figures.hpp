#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "sim_hal/scenario/random_scenario.hpp"
#include "tests/support/simulated_lift.hpp"

namespace colift::tests {

/// Figures over many simulated lifts with a wanted share of one half.
struct LiftFigures {
  int trials = 0, lifted = 0, hit_something = 0;
  double tilt_median_deg = 0, tilt_p95_deg = 0;
  double share_within = 0;  ///< Part of the lifts whose true share is within 0.07 of the wanted one.
  double share_error_p90 = 0;
  double partner_p90_m = 0;  ///< Error of the seen grasp.
  double slip_p95_m = 0;
  double real_time = 0;                 ///< Simulated seconds per second, over all.
  std::vector<std::string> not_lifted;  ///< A sentence each.
};

/// Lifts random scenarios with seeds first to first + count - 1; `done` is told after each. `arrange` may
/// change a scenario before it is lifted.
[[nodiscard]] LiftFigures lift_random(sim_hal::RandomKind kind, control::Method method, std::uint64_t first,
                                      int count, const std::function<void(const std::string&)>& done = {},
                                      const std::function<void(sim_hal::Scenario&)>& arrange = {});

/// Puts the camera beside the robot, from where the faces that it can reach are seen. The thesis's method
/// grasps nothing else.
void see_from_beside_robot(sim_hal::Scenario& scenario);

/// One line on one lift.
[[nodiscard]] std::string line(const std::string& name, const SimulatedLift& lift);

}  // namespace colift::tests
