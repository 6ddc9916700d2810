#pragma once

#include <vector>

#include "sim_hal/synthetic/shapes.hpp"

namespace colift::perception {

using hal::Vec3;

/// Somebody on his back, along y with his head at the upper end, 1.75 m long, about `at` on the floor.
inline std::vector<sim_hal::Shape> lying_person(const Vec3& at, bool hands_behind_head) {
  using sim_hal::Label;
  const auto part = [&](const Vec3& from, const Vec3& to, double radius) {
    return sim_hal::capsule(at + from, at + to, radius, Label::Partner);
  };
  std::vector<sim_hal::Shape> parts{part({0, -0.15, 0.12}, {0, 0.3, 0.12}, 0.12),
                                    sim_hal::sphere(at + Vec3(0, 0.58, 0.12), 0.1, Label::Partner),
                                    part({0, 0.4, 0.12}, {0, 0.5, 0.12}, 0.055)};
  for (const double side : {-1.0, 1.0}) {
    const Vec3 shoulder(side * 0.16, 0.32, 0.1), hip(side * 0.08, -0.2, 0.1), foot(side * 0.12, -1.0, 0.06);
    const Vec3 elbow = hands_behind_head ? Vec3(side * 0.5, 0.48, 0.06) : Vec3(side * 0.22, 0.02, 0.06);
    const Vec3 hand = hands_behind_head ? Vec3(side * 0.07, 0.66, 0.08) : Vec3(side * 0.24, -0.25, 0.06);
    parts.push_back(part(shoulder, elbow, 0.045));
    parts.push_back(part(elbow, hand, 0.035));
    parts.push_back(part(hip, foot, 0.075));
  }
  return parts;
}

}  // namespace colift::perception
