#pragma once

#include <cstddef>

#include "control/session/decide.hpp"
#include "hal/arm.hpp"

namespace colift::control {

/// Sizes (bytes) of values that cross from a program into the library and back. A program that was compiled
/// with other settings of Eigen than the library has others, and corrupts its memory.
struct Layout {
  std::size_t look_input = 0, partner_input = 0, analysis = 0, outcome = 0, config = 0;
  std::size_t pose = 0, arm_state = 0, grasp_candidate = 0;
  bool operator==(const Layout&) const = default;
};

/// As whoever includes this header sees them.
[[nodiscard]] constexpr Layout layout_here() {
  return {sizeof(SceneAnalysisInput),
          sizeof(PartnerInput),
          sizeof(SceneAnalysis),
          sizeof(Outcome),
          sizeof(Config),
          sizeof(hal::Pose),
          sizeof(hal::ArmState),
          sizeof(planner::GraspCandidate)};
}

/// As the library was compiled.
[[nodiscard]] Layout layout_of_library();

}  // namespace colift::control
