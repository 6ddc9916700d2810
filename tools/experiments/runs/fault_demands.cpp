#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "control/task/machine/task_machine.hpp"
#include "tools/experiments/runs/drawn_faults.hpp"

namespace colift::experiments {
namespace {

constexpr double kStops_s = 0.5, kAtRest_rad = 0.03;

/// What a fault asked for and did not get; empty: nothing.
std::string demand_broken(const FaultyLift& lift, const DrawnFault& fault) {
  const double began = began_s(lift, fault);
  if (std::isnan(began)) return {};
  const double ends = std::min(began + fault.for_s, lift.end_s);
  switch (fault.demand) {
    case Demand::None:
      return {};
    case Demand::Rest: {
      const double moved = moved_rad(lift, began + kStops_s, ends);
      return moved > kAtRest_rad ? fmt::format("{}: the arm moved on by {:.2f} rad", fault.what, moved)
                                 : std::string();
    }
    case Demand::NotLifted:
      return lift.record.outcome == control::RunRecord::Result::Lifted ? fault.what + ": reported as lifted"
                                                                       : std::string();
    case Demand::NoGrip: {
      const auto closes = lift.entered.find("close");
      const bool grips =
          closes != lift.entered.end() && closes->second > began + kStops_s && closes->second < ends;
      return grips ? fault.what + ": the hand closed without a picture" : std::string();
    }
  }
  return {};
}

}  // namespace

/// When a fault began in this lift (s of the scenario); NaN: its state was never entered, or the job was
/// over.
double began_s(const FaultyLift& lift, const DrawnFault& fault) {
  double t = fault.at_s;
  if (!fault.in_state.empty()) {
    const auto it = lift.entered.find(fault.in_state);
    if (it == lift.entered.end()) return NAN;
    t += it->second;
  }
  return t < lift.end_s ? t : NAN;
}

std::vector<std::string> objections(const FaultyLift& lift, const std::vector<DrawnFault>& faults) {
  std::vector<std::string> all = lift.verdict.breaches;
  if (!lift.failed.empty()) {
    all.push_back(lift.failed);
    return all;
  }
  using control::Task;
  const Task end = lift.record.states.empty() ? Task::Observe : lift.record.states.back().state;
  if (!control::is_end(end)) all.push_back(fmt::format("ended in {}", word(end)));
  for (const DrawnFault& fault : faults)
    if (auto broken = demand_broken(lift, fault); !broken.empty()) all.push_back(std::move(broken));
  for (const std::string& rule : lift.broken_rules) all.push_back("broke a rule of the wire: " + rule);
  if (lift.divergences > 0) all.push_back("the physics diverged");
  return all;
}

}  // namespace colift::experiments
