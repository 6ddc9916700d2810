#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "control/config.hpp"
#include "control/run_record.hpp"
#include "sim_hal/emulator/krc_faults.hpp"
#include "sim_hal/emulator/krc_report.hpp"
#include "sim_hal/mujoco/sim_world.hpp"
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
  sim_hal::SimTruth at_end;                ///< The world when the job was over.
  std::optional<sim_hal::KrcReport> wire;  ///< Of a lift over the arm's wire.
};

/// How the arm is reached.
struct OverWire {
  /// What goes wrong there, and in which state of the task: a fault's time counts from the first entry.
  struct Fault {
    sim_hal::KrcFault fault;
    control::Task in = control::Task::Observe;
  };
  std::vector<Fault> faults;
};

[[nodiscard]] SimulatedLift simulate(const sim_hal::Scenario& scenario, control::Method method,
                                     std::uint64_t seed, control::Config config = control::run_defaults(),
                                     const std::optional<OverWire>& wire = std::nullopt);

/// Value below which the part `p` of the numbers lies; NaN of none.
[[nodiscard]] double quantile(std::vector<double> values, double p);

}  // namespace colift::tests
