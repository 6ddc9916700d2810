#pragma once

#include <array>
#include <string_view>
#include <vector>

#include "sim_hal/synthetic/hash_random.hpp"
#include "sim_hal/synthetic/shapes.hpp"

namespace colift::sim_hal {

/// How a person may be found in a room before a robot is to look at what stands there.
enum class Stance {
  Standing,
  Stooping,    ///< On straight legs, trunk bent forward by 35 to 95 degrees.
  SittingLow,  ///< On the floor, legs stretched, bent or apart.
  Crouching,   ///< On both feet, knees at the chest.
  Kneeling,    ///< On both knees, upright or bent forward.
  OnOneKnee,
  OnAllFours,
  LyingOnBack,
  LyingFaceDown,
  LyingOnSide,  ///< Stretched to curled.
};
inline constexpr std::array kStances{
    Stance::Standing,  Stance::Stooping,   Stance::SittingLow,  Stance::Crouching,     Stance::Kneeling,
    Stance::OnOneKnee, Stance::OnAllFours, Stance::LyingOnBack, Stance::LyingFaceDown, Stance::LyingOnSide};
[[nodiscard]] std::string_view word(Stance stance);

/// A person in a stance, with joint angles and a height (1.5 to 1.95 m) that are drawn: capsules of a
/// skeleton with Label::Partner, the lowest of them on the floor z = 0, the pelvis above `at` (W, m), turned
/// by `yaw` (rad; 0: facing, or with the head towards, Wx). Segment lengths after Drillis and Contini 1966.
[[nodiscard]] std::vector<Shape> person_in(Stance stance, Draws& draws, const Vec3& at, double yaw);

}  // namespace colift::sim_hal
