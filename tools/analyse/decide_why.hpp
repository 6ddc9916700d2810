#pragma once

#include <string>

#include "control/session/decide.hpp"
#include "hal/types/result.hpp"

namespace colift::tools {

/// One candidate of a decision, explained: how its cost is made up, and what stands against it.
struct WhyCandidate {
  std::size_t index = 0;
  bool scored = false;
  /// Terms of thesis eq. 4.5 for a lift of mass_kg (N^2): force and torque of the partner, then of the robot.
  double partner_force = 0.0, partner_torque = 0.0, robot_force = 0.0, robot_torque = 0.0;
  double cost = 0.0, share = 0.0;
  double from_optimum_m = 0.0;
  int rank = 0, possible = 0;  ///< Among the possible ones, 1 is the cheapest; 0: it is none of them.
  std::string text;            ///< All of it in sentences, with what the chosen one costs beside it.
};

/// Errors: BadInput (no candidate has that id, with the ids that there are).
[[nodiscard]] hal::Result<WhyCandidate> explain_candidate(const control::Outcome& outcome,
                                                          const control::Config& config, int id);

/// A document of `decide` with the explanation under "why".
[[nodiscard]] std::string with_why(const std::string& document, const control::Outcome& outcome,
                                   const WhyCandidate& why);

}  // namespace colift::tools
