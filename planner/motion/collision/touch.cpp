#include "planner/motion/collision/touch.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "hal/types/units.hpp"

namespace colift::planner {

std::string Touch::text() const {
  if (with == With::Nothing) return "nothing is touched";
  std::string name = part;
  std::replace(name.begin(), name.end(), '_', ' ');
  if (with == With::Limits) {
    return fmt::format("{} is {:.1f} deg beyond its limit", name, hal::rad_to_deg(depth_m));
  }
  const char* to = "an obstacle";
  if (with == With::Target) to = "the object";
  if (with == With::Ground) to = "the ground";
  if (with == With::Itself) to = "each other";
  const bool many = with == With::Itself;
  if (depth_m <= 0.0) return fmt::format("{} {} {}", name, many ? "touch" : "touches", to);
  return fmt::format("{} {} {:.0f} mm too near to {}", name, many ? "come" : "comes",
                     std::max(1.0, 1e3 * depth_m), to);
}

}  // namespace colift::planner
