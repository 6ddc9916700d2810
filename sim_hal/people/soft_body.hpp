#pragma once

#include <array>

#include "sim_hal/people/body_region.hpp"
#include "sim_hal/synthetic/shapes.hpp"

namespace colift::sim_hal {

/// Parts of a body that are pushed away together: the head, the trunk with neck and shoulders, and each
/// segment of each limb.
inline constexpr std::size_t kBodyGroups = 14;
[[nodiscard]] std::size_t group_of(const Shape& part);

/// A body that is pushed away from where its script has it. Every group is a point mass (the effective mass
/// of its region) on a spring with damping that stands for the muscles, which hold no more than a person
/// does: a hand 40 N, a trunk 150 N. Skin and flesh are the other spring, in the contact (contact_force_n).
/// A script that goes on where the body cannot pulls with that and no more.
class SoftBody {
 public:
  /// 1 ms: forces of all contacts on each group (N, W).
  void step(const std::array<Vec3, kBodyGroups>& force_W);

  /// Whether every group is where the script has it.
  [[nodiscard]] bool at_rest() const;
  /// How far a group is from where the script has it, and how fast it moves beside it.
  [[nodiscard]] const Vec3& offset(std::size_t group) const { return offset_[group]; }
  [[nodiscard]] const Vec3& velocity(std::size_t group) const { return velocity_[group]; }

 private:
  std::array<Vec3, kBodyGroups> offset_ = zeros(), velocity_ = zeros();
  static std::array<Vec3, kBodyGroups> zeros();
};

/// Force of flesh that is pressed by `depth_m` with `closing_m_s` (N): the region's spring with a little
/// damping (Hunt and Crossley's form, so that it begins at zero), never a pull.
[[nodiscard]] double contact_force_n(const RegionProperties& region, double depth_m, double closing_m_s);

}  // namespace colift::sim_hal
