#pragma once

#include <cstdint>
#include <string>

#include "planner/motion/collision/collision_scene.hpp"
#include "planner/motion/free_space.hpp"
#include "planner/motion/search_config.hpp"
#include "planner/motion/trajectory/joint_path.hpp"

namespace colift::planner {

/// Where a plan may start from.
struct Departure {
  JointPath path;          ///< Start, and one more position if the start itself is not clear of everything.
  double reach_rad = 0.0;  ///< Around the start so far (in any joint) only the exact checker's word counts.
  std::string note;        ///< Said when it had to move away first.
};

/// The start, if the fast checker finds it free. If it only comes too near to something and really touches
/// nothing (the exact checker's word), the nearest free position to which a straight motion touches nothing.
/// Error: what the start touches.
[[nodiscard]] tl::expected<Departure, std::string> depart(const hal::JointVector& start, FastChecker& fast,
                                                          ExactChecker& exact, const JointBox& box,
                                                          double exact_step_rad, std::uint64_t seed,
                                                          const EscapeConfig& config = {});

}  // namespace colift::planner
