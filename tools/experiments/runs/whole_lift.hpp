#pragma once

#include <cmath>
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "control/config/config.hpp"
#include "control/task/run_record.hpp"
#include "hal/types/result.hpp"
#include "sim_hal/imperfect/rig_errors.hpp"
#include "sim_hal/judge/verdict.hpp"
#include "sim_hal/mujoco/sim_world.hpp"
#include "sim_hal/scenario/scenario.hpp"
#include "tools/experiments/trials/sighting.hpp"

namespace colift::experiments {

/// One whole job on the simulated rig, as `colift run` does it, and how good it truly was.
struct WholeLift {
  control::RunRecord record;
  double tilt_deg = NAN, height_m = NAN, share_robot = NAN;  ///< True, means at the top.
  double slip_m = NAN;
  bool hit_something = false;
  sim_hal::Verdict verdict;         ///< Of the simulation's judge.
  double height_at_let_go_m = NAN;  ///< True, of the object, at the partner's first let-go.
  double let_go_s = NAN;            ///< When that was, of the record's time.
};

/// How a run is cut short, where the rest of it says nothing new.
struct CutShort {
  /// When the hand opens without having lifted, after the partner has let go.
  bool at_release_before_lift = false;
  double paused_s = INFINITY;          ///< After this time in Pause.
  std::vector<control::Task> at = {};  ///< When it enters one of these.
};

/// What a trial changes and observes. All of it may be empty.
struct LiftHooks {
  Settings settings = {};
  /// At full speed, which no configuration allows without monitoring: to measure what monitoring costs.
  bool without_monitor = false;
  std::function<void(const sim_hal::SimWorld&)> started;  ///< Before the first cycle.
  /// About 30 times a second, with the state of the task.
  std::function<void(const sim_hal::SimWorld&, control::Task)> each_frame;
  std::function<void(const sim_hal::TickReport&)> each_tick;
  std::function<void(const control::RunRecord&)> ended;  ///< After the last cycle.
  CutShort cut = {};
  std::optional<sim_hal::RigErrors> errors = {};  ///< Of the sensors; unset: ideal.
};

/// Errors: BadConfig (the scenario), and those of devices at the start.
[[nodiscard]] hal::Result<WholeLift> run_whole_lift(const sim_hal::Scenario& scenario, control::Method method,
                                                    std::uint64_t seed, const LiftHooks& with = {});

/// "lifted", "aborted" or "refused".
[[nodiscard]] const char* word(control::RunRecord::Result outcome);

}  // namespace colift::experiments
