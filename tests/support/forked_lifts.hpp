#pragma once

#include <bitset>
#include <cmath>
#include <string>
#include <vector>

#include "control/task/run_record.hpp"
#include "tests/support/simulated_lift.hpp"

namespace colift::tests {

/// A fault at an entry into a state: its time counts from there.
struct ForkedFault {
  WireFault fault;
  control::Task in = control::Task::Observe;
  bool each_time = false;  ///< At every entry, not at the first alone.
};

/// How the lift ended that suffered the fault; what a pipe carries.
struct ForkedEnd {
  bool ran = false;   ///< The state was entered, and the lift came to its end.
  std::string crash;  ///< How the lift's process ended, if not well.
  control::RunRecord::Result outcome = control::RunRecord::Result::Refused;
  control::Task end = control::Task::Observe;  ///< The last state.
  std::string reason, told;                    ///< The reason; everything that was said.
  bool hand_keeps_grip = false, hit_something = false;
  bool touches_object = false;  ///< The hand, when the job was over.
  unsigned divergences = 0, broken_rules = 0;
  double in_state_s = 0.0;                  ///< Spent in the fault's state, from its first entry.
  double most_open_while_loaded_rad = NAN;  ///< SimulatedLift's.
  std::bitset<control::kTasks> visited;     ///< States that the job came to, by their number.
};

/// One lift without a fault, and for each fault one that branches off it in a process of its own when the
/// state is first entered: what came before is computed once for all. One after the other, in the order of
/// `faults`. The lift runs in step, in one thread, so that a fork is all of it.
[[nodiscard]] std::vector<ForkedEnd> lift_forked(const sim_hal::Scenario& scenario,
                                                 const control::Config& config, const OverWire& wire,
                                                 const std::vector<ForkedFault>& faults);

}  // namespace colift::tests
