#pragma once

#include <optional>

#include "sim_hal/synthetic/shapes.hpp"

namespace colift::sim_hal {

/// How the hand lies at a contact: frame with `out` away from the object, `along` the width of the hand and
/// `across` the thickness that it holds (thumb on its positive side), all unit vectors in W.
struct Grip {
  enum class Kind {
    Pinch,  ///< Thumb and fingers on both sides of something thin.
    Wrap,   ///< Fingers around a round bar.
    Hook,   ///< Palm on a face, fingers over the edge above it.
    Flat,   ///< Palm and fingers on a face.
  };
  Kind kind = Kind::Flat;
  Vec3 at = Vec3::Zero();  ///< The contact, moved to the middle of the thickness for a pinch.
  Vec3 out = Vec3::UnitX(), along = Vec3::UnitY(), across = Vec3::UnitZ();
  double thickness = 0.0;  ///< Of what is pinched; diameter of what is wrapped (m).

  /// Where the wrist comes to lie.
  [[nodiscard]] Vec3 wrist() const;
};

/// The grip that a hand coming from `from` takes at a point on the surface of the world's target.
[[nodiscard]] Grip find_grip(const World& world, const Vec3& contact, const Vec3& from);

/// Adds palm, thumb and four fingers.
void add_hand(World& world, const Grip& grip);

/// A standing, leaning or squatting person by what decides the posture. Measures of an adult, about 1.75 m
/// tall upright (segment lengths after Drillis and Contini 1966, rounded to cm).
struct Posture {
  Vec3 right_shoulder = Vec3::Zero(), left_shoulder = Vec3::Zero();
  Vec3 facing = Vec3::UnitX();                  ///< Horizontal unit vector.
  std::optional<Vec3> right_wrist, left_wrist;  ///< Unset: the arm hangs down.
  std::optional<Vec3> hip;                    ///< Middle of both hips; unset: as the shoulders' height asks.
  std::optional<Vec3> right_foot, left_foot;  ///< Ankles; unset: below the hips.
  /// Tip of the right hand's fingers, for a flat hand of its own (one without a Grip), 16.5 cm from the
  /// wrist.
  std::optional<Vec3> right_tip;
  bool toes = false;  ///< Feet with flat toes, 22 cm from ankle to tip.
};
inline constexpr double kHandLength_m = 0.165, kAnkleToToe_m = 0.22;
void add_person(World& world, const Posture& posture);

}  // namespace colift::sim_hal
