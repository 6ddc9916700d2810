#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "planner/motion/free_space.hpp"
#include "planner/motion/trajectory/joint_path.hpp"

namespace colift::planner {

/// How long a search may be: by the work done, never by a clock, so that the same seed gives the same plan on
/// any machine.
struct SearchBudget {
  std::size_t samples = 20000;  ///< Joint positions drawn.
  double max_edge_rad = 1.0;    ///< By which a tree grows (Euclidean).
};

struct FoundPath {
  JointPath path;        ///< From the start to a goal; every edge was found free.
  std::size_t goal = 0;  ///< Index of the goal that it ends in.
};

/// Way from `start` to any of `goals` by RRT-Connect (Kuffner and LaValle, ICRA 2000; OMPL's), two trees that
/// grow towards each other. Start and goals have to be free and in the box. nullopt when the budget is used
/// up. `samples_used` is added to.
[[nodiscard]] std::optional<FoundPath> rrt_connect(const FreeSpace& space, const JointBox& box,
                                                   const hal::JointVector& start,
                                                   std::span<const hal::JointVector> goals,
                                                   const SearchBudget& budget, std::uint64_t seed,
                                                   std::size_t& samples_used);

}  // namespace colift::planner
