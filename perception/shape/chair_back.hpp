#pragma once

#include <optional>

#include "perception/shape/shape_evidence.hpp"

namespace colift::perception {

/// The back of a chair, as far as its points show it.
struct ChairBack {
  Vec3 out = Vec3::UnitX();    ///< Level, from the seat's middle to the back; one of the seat's axes.
  Vec3 center = Vec3::Zero();  ///< Middle of the back, on the seat's middle line.
  double width_m = 0.0, height_m = 0.0;
  double fill = 0.0;             ///< Part of width times height that is material.
  double relative_sigma = 0.0;   ///< Of its mass: fill and thickness.
  bool seen_from_front = false;  ///< The fill was counted; else it is that of usual chairs.
};

/// Points well above the seat stand over that side of it where they are farthest out. How much of the back is
/// material (posts and slats, or a plate) shows only from the front; from the side it is assumed
/// (CompletionConfig::back_fill). nullopt where no point is above the seat.
[[nodiscard]] std::optional<ChairBack> find_chair_back(const ShapeEvidence& seen, const Rectangle& seat,
                                                       const CompletionConfig& config);

}  // namespace colift::perception
