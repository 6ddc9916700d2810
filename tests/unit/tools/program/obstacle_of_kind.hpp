#pragma once

#include <string>
#include <vector>

#include "tools/bring_up/hal_arm_obstacles.hpp"

namespace colift::test {

/// Null where there is none.
inline const tools::Obstacle* obstacle(const std::vector<tools::Obstacle>& all, const std::string& kind) {
  for (const auto& o : all)
    if (o.kind == kind) return &o;
  return nullptr;
}

}  // namespace colift::test
