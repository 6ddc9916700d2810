#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "control/config/config.hpp"
#include "control/task/run_record.hpp"
#include "hal/depth_camera.hpp"
#include "sim_hal/emulator/hand/hand_faults.hpp"
#include "sim_hal/emulator/hand/hand_report.hpp"
#include "sim_hal/emulator/krc/krc_faults.hpp"
#include "sim_hal/emulator/krc/krc_report.hpp"
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
  double to_limit_deg = INFINITY;          ///< Least distance of any joint from its limit, in the whole job.
  int person_contacts = 0;                 ///< Cycles in which the robot touched people beside the partner.
  sim_hal::SimTruth at_end;                ///< The world when the job was over.
  std::optional<sim_hal::KrcReport> wire;  ///< Of a lift over the arm's wire.
  std::optional<sim_hal::HandEmulatorReport> pucks;  ///< Of one over the hand's.
  int frames_lost = 0;                               ///< On a bus of this machine.
  double most_open_while_loaded_rad =
      NAN;  ///< How far a finger went open between a grip and the way down's end.
};

/// A fault of the arm's wire or of the hand's.
using WireFault = std::variant<sim_hal::KrcFault, sim_hal::HandFault>;

/// Which device is reached over its wire.
struct OverWire {
  bool arm = true, hand = false;  ///< One of them.
  std::string hand_bus;           ///< A bus of this machine; empty: one in memory.

  /// What goes wrong there, and in which state of the task: a fault's time counts from the first entry.
  struct Fault {
    sim_hal::KrcFault fault;
    control::Task in = control::Task::Observe;
  };
  std::vector<Fault> faults;
  struct OfHand {
    sim_hal::HandFault fault;
    control::Task in = control::Task::Observe;
    bool each_time = false;  ///< At every entry, not at the first alone.
  };
  std::vector<OfHand> hand_faults;
  hal::Vec3 camera_off_m = hal::Vec3::Zero();  ///< Where the rig believes the camera beside where it is.
  /// Asked at the start of the job and whenever it enters a state: what goes wrong on the wire from then on.
  std::function<std::optional<WireFault>(control::Task)> entered;
  int extrapolated = 3;       ///< Missing answers in a row that the arm's controller bridges.
  double min_rate = 0.80;     ///< Of answers: with fewer its quality is unacceptable.
  double joint_rad_s = 10.0;  ///< Faster joints it does not let pass, as in its mode T1.
};

/// What the job gets in place of the simulated camera, and from it.
using ThroughCamera = std::function<std::unique_ptr<hal::DepthCamera>(std::unique_ptr<hal::DepthCamera>)>;

[[nodiscard]] SimulatedLift simulate(const sim_hal::Scenario& scenario, control::Method method,
                                     std::uint64_t seed, control::Config config = control::run_defaults(),
                                     const std::optional<OverWire>& wire = std::nullopt,
                                     const ThroughCamera& through = {});

/// Distance of the joint that is nearest to its limit.
[[nodiscard]] double to_limit_deg(const hal::RobotModel& robot, const hal::JointVector& q_rad);

/// Value below which the part `p` of the numbers lies; NaN of none.
[[nodiscard]] double quantile(std::vector<double> values, double p);

}  // namespace colift::tests
