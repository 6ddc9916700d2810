#pragma once

#include <cstdint>

#include "planner/motion/free_space.hpp"
#include "planner/motion/search_config.hpp"
#include "planner/motion/trajectory/joint_path.hpp"

namespace colift::planner {

/// Shortens a path of free edges: first to the farthest way point that a straight line reaches, then between
/// random points on the path, then corners are pulled inwards, also joint by joint, and cut (after Geraerts
/// and Overmars, IJRR 2007). Start and end stay. Every new edge was found free. Deterministic for a seed.
[[nodiscard]] JointPath shortcut(JointPath path, const FreeSpace& space, std::uint64_t seed,
                                 const ShortcutConfig& config = {});

}  // namespace colift::planner
