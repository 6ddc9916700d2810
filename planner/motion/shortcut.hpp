#pragma once

#include <cstdint>

#include "planner/motion/joint_path.hpp"

namespace colift::planner {

struct ShortcutConfig {
  int rounds = 160;        ///< Random shortcuts that are tried at most.
  int give_up_after = 32;  ///< Failures in a row that end the search.
  int passes = 4;          ///< Over all corners, at most.
  double min_gain = 0.01;  ///< Smaller gains are not worth a check (part of the path's length).
};

/// Shortens a path of free edges: first to the farthest way point that a straight line reaches, then between
/// random points on the path, then corners are pulled inwards, also joint by joint, and cut (after Geraerts
/// and Overmars, IJRR 2007). Start and end stay. Every new edge was found free. Deterministic for a seed.
[[nodiscard]] JointPath shortcut(JointPath path, const FreeSpace& space, std::uint64_t seed,
                                 const ShortcutConfig& config = {});

}  // namespace colift::planner
