#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include "sim_hal/synthetic/shapes.hpp"

namespace colift::sim_hal {

/// Where a body is touched, as limits of force are given (ISO/TS 15066 Annex A groups; hand holds fingers,
/// thigh the knee, back the shoulders).
enum class BodyRegion : std::uint8_t {
  Hand,
  LowerArm,
  UpperArm,
  Abdomen,
  Chest,
  Back,
  Thigh,
  LowerLeg,
  Foot,
  Face,
  Skull,
  Neck
};
inline constexpr std::size_t kBodyRegions = 12;

/// "lower-arm".
[[nodiscard]] std::string_view to_string(BodyRegion region);

/// How soft a region is and how much of the body moves with it.
struct RegionProperties {
  double stiffness_n_m = 0.0;
  double mass_kg = 0.0;
};

/// Effective spring constants and masses of the model of ISO/TS 15066 Annex A (two bodies and a spring), as
/// its secondary sources give them. It has no foot and no neck: a foot is as stiff as a hand and as heavy as
/// a leg; a neck is as a chest, with the mass of a head.
[[nodiscard]] RegionProperties properties_of(BodyRegion region);

/// Region of a part that is touched. `along`: 0 at the beginning of its capsule (hip, shoulder, elbow, knee),
/// 1 at its end. `push_W`: unit vector of the force on it; `facing_W`: where the person looks.
[[nodiscard]] BodyRegion region_of(BodyPart part, double along, const Vec3& push_W, const Vec3& facing_W);

}  // namespace colift::sim_hal
