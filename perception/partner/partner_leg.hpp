#pragma once

#include <cstdint>
#include <span>

#include "hal/config/range.hpp"
#include "perception/organised_cloud.hpp"
#include "perception/scene.hpp"

namespace colift::perception {

/// Limits between hands and legs, placed between 491 hands and 412 legs in synthetic frames
/// (docs/decisions/0003).
struct LegConfig {
  double min_height_m = 0.20;         ///< What is touched lower may be held by a hand beside the ground.
  double max_height_m = 0.85;         ///< Higher than this no leg touches.
  double foot_height_m = 0.12;        ///< What lies lower is a foot.
  double wrist_below_palm_m = 0.145;  ///< Skin of the wrist below a palm that hangs from an edge.
  double foot_aside_m = 0.20;
  double min_foot_area_m2 = 0.001;  ///< Hands higher than min_height_m have nothing there.
  double shoe_from_m = 0.10, shoe_to_m = 0.25;
  double min_shoe_area_m2 = 0.0045;  ///< Hands and forearms show 0.0038 at most.
  double limb_from_m = 0.06, limb_to_m = 0.20;
  double min_limb_area_m2 = 0.0075;  ///< Hands over an edge show 0.009 above and 0.0064 below at most.
  double body_radius_m = 0.25;
  double min_body_area_m2 = 0.048;  ///< Hands with forearms show 0.044 at most.
  double min_second_leg_area_m2 = 0.034;
  double leg_distance_m = 0.25;

  template <class Visitor>
  void visit(Visitor& v) {
    const hal::Range length{0.0, 2.5}, area{0.0, 1.0};
    v("min_height_m", min_height_m, length,
      "Height of a touch below which only a shoe beside it tells a leg from a hand (m).");
    v("max_height_m", max_height_m, length, "Max height of a touch by a leg (m).");
    v("foot_height_m", foot_height_m, length, "Max height of the pixels that count as a foot (m).");
    v("wrist_below_palm_m", wrist_below_palm_m, length,
      "Length of the wrist below a palm that hangs from an edge; it is no foot (m).");
    v("foot_aside_m", foot_aside_m, length,
      "Max horizontal distance of a foot from the touch of its leg (m).");
    v("min_foot_area_m2", min_foot_area_m2, area,
      "Min visible area of a foot under the touch of a leg (m^2).");
    v("shoe_from_m", shoe_from_m, length, "Min horizontal distance of a shoe beside a low touch (m).");
    v("shoe_to_m", shoe_to_m, length, "Max horizontal distance of a shoe beside a low touch (m).");
    v("min_shoe_area_m2", min_shoe_area_m2, area, "Min visible area of a shoe beside a low touch (m^2).");
    v("limb_from_m", limb_from_m, length,
      "Min height difference of the parts of a limb above and below the touch (m).");
    v("limb_to_m", limb_to_m, length, "Max distance of these parts from the touch (m).");
    v("min_limb_area_m2", min_limb_area_m2, area,
      "Min visible area of a limb above, and below, the touch for it to be a leg (m^2).");
    v("body_radius_m", body_radius_m, length, "Radius around the touch within which body is counted (m).");
    v("min_body_area_m2", min_body_area_m2, area,
      "Min visible area of body in that radius for it to be a thigh or trunk (m^2).");
    v("min_second_leg_area_m2", min_second_leg_area_m2, area, "The same beside a leg that is certain (m^2).");
    v("leg_distance_m", leg_distance_m, length,
      "Max distance between the touches of both legs of a person (m).");
  }
};

/// What tells a leg, a shoe or the trunk that leans against the object from a hand that holds it.
enum class LegSign {
  None,      ///< It may be a hand.
  Standing,  ///< The body comes from the ground just below: a shin or thigh.
  Shoe,      ///< The object lies low, and the body lies beside it on the ground.
  Passing,   ///< The limb continues above and below the place: a thigh along an edge that hides the shin.
  Thick,     ///< More body around the place than a hand with its forearm has: thigh or trunk.
};

/// Judges a touch at `touch_W` by the pixels of the person around it (any pixels of `current` that changed;
/// those far from the touch do not count). A forearm comes to a hand from above or from the side and is thin;
/// a leg has the ground under it. Seen from behind the object, only thickness is left to tell.
/// `beside_a_leg`: a sure leg touches within LegConfig::leg_distance_m, so that less body is enough to be the
/// other one.
[[nodiscard]] LegSign leg_sign(const OrganisedCloud& current, std::span<const std::uint32_t> body_pixels,
                               const Vec3& touch_W, const Ground& ground, bool beside_a_leg = false,
                               const LegConfig& config = {});

}  // namespace colift::perception
