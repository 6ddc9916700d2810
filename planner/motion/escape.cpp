#include "planner/motion/escape.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "planner/motion/joint_random.hpp"

namespace colift::planner {
namespace {

using hal::JointVector;

bool touches_nothing(ExactChecker& exact, const JointVector& from, const JointVector& to, double step_rad) {
  const int steps = std::max(1, static_cast<int>(std::ceil(joint_distance(from, to) / step_rad)));
  for (int k = 1; k <= steps; ++k) {
    const Touch touch = exact.what_touches(from + (static_cast<double>(k) / steps) * (to - from));
    if (touch.with != Touch::With::Nothing) return false;
  }
  return true;
}

}  // namespace

tl::expected<Departure, std::string> depart(const JointVector& start, FastChecker& fast, ExactChecker& exact,
                                            const JointBox& box, double exact_step_rad, std::uint64_t seed,
                                            const EscapeConfig& config) {
  if (fast.is_free(start)) return Departure{{start}, 0.0, {}};
  const Touch near = fast.what_touches(start);
  if (near.with == Touch::With::Limits) return tl::unexpected(near.text());
  if (const Touch touch = exact.what_touches(start); touch.with != Touch::With::Nothing) {
    return tl::unexpected(touch.text());
  }
  JointRandom random(seed);
  for (const double radius : config.radii_rad) {
    for (int i = 0, tried = 0; i < config.tries && tried < config.exact_tries; ++i) {
      const JointVector q = random.near(start, radius, box);
      if (!fast.is_free(q)) continue;
      ++tried;
      if (!touches_nothing(exact, start, q, exact_step_rad)) continue;
      return Departure{{start, q},
                       joint_distance(start, q),
                       fmt::format("at the start {}; the arm first moves {:.2f} rad away", near.text(),
                                   joint_distance(start, q))};
    }
  }
  return tl::unexpected(fmt::format("{}, and no free position was found within {:.2f} rad", near.text(),
                                    config.radii_rad.empty() ? 0.0 : config.radii_rad.back()));
}

}  // namespace colift::planner
