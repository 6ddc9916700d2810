#pragma once

#include <atomic>
#include <functional>
#include <string>
#include <vector>

#include "tools/bring_up/control/control_arm.hpp"

namespace colift::tools {

/// One strategy of a switch.
struct SwitchStep {
  std::string control;
  bool reached = false;    ///< It was commanded.
  double took_s = 0.0;     ///< From the end of the one before to the first command.
  double held_s = 0.0;     ///< For so long it was commanded.
  double moved_rad = 0.0;  ///< Max distance of a joint from where it was when the task began.
};

/// How it ended: `reason` is empty when each strategy was commanded for its time.
struct SwitchEnd {
  std::string reason;
  bool interrupted = false;
  std::vector<SwitchStep> steps;
};

/// Commands the measured pose in one strategy after the other, each for `each_s`, over one link: between two
/// of them the arm leaves command mode, since the strategy changes in monitor mode only, and rests. A switch
/// that fails leaves the arm at rest outside of command mode and ends the task.
/// \param guarded  The arm to command, with `arm` inside of it.
/// \param asking   Told before command mode is asked for (true), and when commands begin (false).
/// \param why      Why commands are not taken, in a sentence.
[[nodiscard]] SwitchEnd run_switch(hal::Arm& guarded, ControlArm& arm,
                                   const std::vector<std::string>& controls, double each_s,
                                   const hal::Clock& clock, const std::atomic<bool>& interrupted,
                                   const std::function<void(bool)>& asking,
                                   const std::function<std::string()>& why);

/// A line for each strategy.
[[nodiscard]] std::string describe(const SwitchEnd& end);

}  // namespace colift::tools
