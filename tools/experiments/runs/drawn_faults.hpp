#pragma once

#include <string>
#include <vector>

#include "tools/experiments/experiment.hpp"
#include "tools/experiments/runs/faulty_lift.hpp"

namespace colift::experiments {

/// What a fault asks of the job beyond a silent judge.
enum class Demand {
  None,
  Rest,       ///< The arm is at rest 0.5 s after its begin and while it lasts.
  NotLifted,  ///< The job does not end as lifted.
  NoGrip,     ///< While it lasts the hand does not begin to close.
};

/// One fault of a trial.
struct DrawnFault {
  std::string group;  ///< camera, arm, hand, force, partner, people, clutter, operator
  std::string what;   ///< "camera unplug, 1.2 s"
  std::string in_state;
  double at_s = 0.0;  ///< Since the state was first entered; empty state: since the start.
  double for_s = 0.0;
  Demand demand = Demand::None;
};

struct DrawnTrial {
  FaultyScene scene;
  std::vector<DrawnFault> faults;
};

/// One to three faults in a table, box, pipe or chair, each at a random instant of a random state. Same
/// trial, same faults.
[[nodiscard]] DrawnTrial draw_faults(const Trial& trial);

/// When a fault began in a lift (s of the scenario); NaN: its state was never entered, or the job was over.
[[nodiscard]] double began_s(const FaultyLift& lift, const DrawnFault& fault);

/// Everything that speaks against a lift with these faults; empty: it survived them.
[[nodiscard]] std::vector<std::string> objections(const FaultyLift& lift,
                                                  const std::vector<DrawnFault>& faults);

/// Of Trial::own_seed(), for the world of such a lift.
inline constexpr std::uint64_t kFaultyStream = 13;

/// What is said of every such lift.
[[nodiscard]] control::TaskSaid faulty_task();

/// Groups of faults, in the order of the catalogue.
[[nodiscard]] const std::vector<std::string>& fault_groups();

}  // namespace colift::experiments
