#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "control/config/config.hpp"
#include "control/task/run_record.hpp"
#include "sim_hal/judge/verdict.hpp"
#include "sim_hal/scenario/scenario.hpp"

namespace colift::experiments {

/// Which device is reached through its real driver, over a wire in memory to its emulated far end; the others
/// are simulated.
enum class Wire { None, Arm, Hand };
[[nodiscard]] const char* word(Wire wire);

/// What a lift with faults is made of.
struct FaultyScene {
  sim_hal::Scenario scenario;  ///< Faults of the wired device are those of its emulator.
  Wire wire = Wire::None;
  std::optional<double> interrupted_s;  ///< The operator ends the program then.
};

/// `colift recover` after a job that stopped: whatever was wrong is mended, an operator confirms every step,
/// and people take the object where it cannot be lowered, or is in the way of the hand.
struct FaultyRecovery {
  bool home = false;            ///< The arm is, with an open hand.
  std::string steps, reason;    ///< "lower, release, draw-back, held"
  bool somebody_there = false;  ///< It was never free to move.
};

/// How it ended, as the program says and as the world knows.
struct FaultyLift {
  control::RunRecord record;
  sim_hal::Verdict verdict;
  std::string failed;  ///< An exception, an error at the start, or no end in time; empty: it came to its end.
  std::map<std::string, double> entered;   ///< First entry into each state (s of the scenario).
  std::vector<std::string> broken_rules;   ///< What the wire's far end had to complain of.
  int divergences = 0;                     ///< Of the physics.
  bool hit_something = false;              ///< A link of the arm met anything at any time.
  std::optional<FaultyRecovery> recovery;  ///< Of a job that ended as stopped.

  /// The arm at an instant of the scenario (rad); what touches it.
  struct Sample {
    double t_s;
    hal::JointVector q_rad;
    bool touched;
  };
  std::vector<Sample> motion;  ///< 100 a second.
  double end_s = 0.0;          ///< Of the job, in the scenario's time.
};

/// Longest that a job may last (s of the robot's time), whatever happens.
inline constexpr double kMaxJob_s = 240.0;

/// One whole job, in step with the simulation. Never throws for what the job does. Errors: BadConfig (the
/// scenario).
[[nodiscard]] hal::Result<FaultyLift> run_faulty_lift(const FaultyScene& scene, const control::Config& config,
                                                      control::Method method, std::uint64_t seed);

/// How far the fastest joint moved between two instants while nobody touched the arm (rad).
[[nodiscard]] double moved_rad(const FaultyLift& lift, double from_s, double to_s);

}  // namespace colift::experiments
