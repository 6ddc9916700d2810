#pragma once

#include <cstdint>
#include <span>

#include "perception/organised_cloud.hpp"
#include "perception/scene.hpp"

namespace colift::perception {

/// What tells a leg, a shoe or the trunk that leans against the object from a hand that holds it.
enum class LegSign {
  None,      ///< It may be a hand.
  Standing,  ///< The body comes from the ground just below: a shin or thigh.
  Shoe,      ///< The object lies low, and the body lies beside it on the ground.
  Passing,   ///< The limb goes on above and below the place: a thigh along an edge that hides the shin.
  Thick,     ///< More body around the place than a hand with its forearm has: thigh or trunk.
};

/// Judges a touch at `touch_W` by the pixels of the person around it (any pixels of `current` that changed;
/// those far from the touch do not count). A forearm comes to a hand from above or from the side and is thin;
/// a leg has the ground under it. Seen from behind the object, only thickness is left to tell.
/// `beside_a_leg`: a sure leg touches within 25 cm, so that less body is enough to be the other one.
[[nodiscard]] LegSign leg_sign(const OrganisedCloud& current, std::span<const std::uint32_t> body_pixels,
                               const Vec3& touch_W, const Ground& ground, bool beside_a_leg = false);

}  // namespace colift::perception
