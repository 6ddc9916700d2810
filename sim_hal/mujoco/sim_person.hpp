#pragma once

#include <optional>

#include "sim_hal/synthetic/shapes.hpp"

namespace colift::sim_hal {

/// A person who holds, comes to hold or has let go of an object with one hand, as a camera sees him.
///
///   PartnerFigure figure = place_partner(world, contact_W, outward_W);  // once per grasp
///   figure.contact_W = X_WT * grasp_T;                                  // every frame
///   figure.presence = presence_at(t - arrival, t - let_go);
///   add_partner(world, figure);
struct PartnerFigure {
  Vec3 contact_W = Vec3::Zero();   ///< On the object's surface; moves with the object while he holds it.
  Vec3 outward_W = Vec3::UnitX();  ///< Horizontal unit vector away from the object's middle.
  /// 1: the hand is on the contact. Down to 0.5: the hand draws back by 25 cm and he steps back. Down to 0:
  /// he walks away; at 0 and below nothing of him is seen.
  double presence = 1.0;
  std::optional<Vec3> second_W;  ///< Where his left hand holds too.
  /// Shoulder of the hand that holds, from the contact, in W. Unset: place_partner() is asked every time.
  std::optional<Vec3> shoulder_W;
};

/// Where he stands: outside of the contact as seen from the object's middle, as near to `outward_W` as he
/// can without standing in object, clutter or wall. `world` holds those and nothing of him.
[[nodiscard]] PartnerFigure place_partner(const World& world, const Vec3& contact_W, const Vec3& outward_W);

/// Where his shoulder is, from the contact (W), when he has stepped aside that way as far as he can without
/// letting go and without standing in something: up to a radian around his hand. Unset: he cannot.
[[nodiscard]] std::optional<Vec3> step_aside(const World& world, const PartnerFigure& figure,
                                             const Vec3& direction_W);

/// Between two places of a shoulder, on a circle around the contact; `part` from 0 to 1.
[[nodiscard]] Vec3 turned(const Vec3& from, const Vec3& to, double part);

/// Adds hand, arm and body, Label::Partner. `world` holds the object (Label::Target), which decides how the
/// hand grips.
void add_partner(World& world, const PartnerFigure& figure);

/// Presence over time. He comes into view one second before the hand is on the contact, and draws back
/// within 0.4 s after letting go. Seconds since the hand was on the contact (negative before), and since he
/// let go (negative or unset: he has not).
/// `leaves`: after that he walks away within a second.
[[nodiscard]] double presence_at(double since_arrival_s, std::optional<double> since_let_go_s = {},
                                 bool leaves = false);

}  // namespace colift::sim_hal
