#pragma once

#include <cstdint>
#include <string>

#include "hal/types/result.hpp"

namespace colift::experiments {

/// One thread of a run stops for a while, at an instant of a state in which the arm moves.
struct Stall {
  std::string thread;  ///< task | colift-arm | colift-hand | other
  std::string state;   ///< approach | lift | lower | retreat
  double delay_s = 0.0, held_s = 0.8;
};

/// What came of it.
struct StalledRun {
  /// stopped, late: at rest within the limit or not. machine: the far ends themselves stood still for more
  /// than 20 ms, not judged. continued: a thread without which the arm may move. at-rest: the arm did not
  /// move; not-reached, no-thread, failed: nothing to judge.
  std::string verdict = "failed";
  double moved_s = 0.0;      ///< From the stall until the arm is at rest ...
  double fast_s = 0.0;       ///< ... until it is slower than 0.05 rad/s: the rest swings out in its springs.
  double speed_rad_s = 0.0;  ///< Of the fastest joint when its thread stopped.
  double gap_s = 0.0;        ///< Longest standstill of the far ends meanwhile.
  std::string end, because;  ///< How the run ended, in its own words.
};

inline constexpr double kRestWithin_s = 0.3;

/// `colift run` in a process of its own, in real time, on emulated far ends in this one; ptrace stops the
/// thread. Errors: BadConfig, DeviceFault (far ends that do not start, no program beside this one).
[[nodiscard]] hal::Result<StalledRun> run_stalled(const Stall& stall, std::uint64_t seed);

}  // namespace colift::experiments
