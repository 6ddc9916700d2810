#include "sim_hal/judge/force_limits.hpp"

namespace colift::sim_hal {

ForceLimit force_limit(BodyRegion region) {
  constexpr double kTransient = 2.0;
  const auto twice = [](double n) { return ForceLimit{n, kTransient * n}; };
  switch (region) {
    case BodyRegion::Hand:
    case BodyRegion::Chest:
      return twice(140.0);
    case BodyRegion::LowerArm:
      return twice(160.0);
    case BodyRegion::UpperArm:
      return twice(150.0);
    case BodyRegion::Abdomen:
      return twice(110.0);
    case BodyRegion::Back:
      return twice(210.0);
    case BodyRegion::Thigh:
      return twice(220.0);
    case BodyRegion::LowerLeg:
    case BodyRegion::Foot:
      return twice(130.0);
    case BodyRegion::Skull:
      return {130.0, 130.0};
    case BodyRegion::Face:
    case BodyRegion::Neck:
      break;
  }
  return {65.0, 65.0};
}

}  // namespace colift::sim_hal
