#pragma once

#include <optional>

#include "perception/shape/shape_evidence.hpp"

namespace colift::perception {

/// The largest cylinder; an upright one goes down to the ground.
[[nodiscard]] CompletedShape complete_cylinder(const ShapeEvidence& seen, const CompletionConfig& config);

/// A prism from its top to the ground. `support` as ShapeEvidence::seen_support() gives it, NaN included.
[[nodiscard]] CompletedShape complete_block(const ShapeEvidence& seen, const ShapeEvidence::Widened& widened,
                                            double support);

/// A plate of the seen thickness on four legs of the seen width.
[[nodiscard]] CompletedShape complete_plate(const ShapeEvidence& seen, const ShapeEvidence::Widened& widened,
                                            double support, const CompletionConfig& config);

/// Seat, four legs and the seen faces of the back, symmetric about the seat's middle.
[[nodiscard]] CompletedShape complete_chair(const ShapeEvidence& seen, const Rectangle& seat,
                                            const CompletionConfig& config);

/// Walls and a bottom, seen from above: faces that look inwards at each other. Nothing where there are none.
[[nodiscard]] std::optional<CompletedShape> complete_open_box(const ShapeEvidence& seen,
                                                              const CompletionConfig& config);

/// Covariance with these standard deviations (m) along axes.
[[nodiscard]] Eigen::Matrix3d spread(const Eigen::Matrix3d& axes, const Vec3& sigma);

/// For what has no known shape.
[[nodiscard]] CompletedShape complete_mirrored(const ShapeEvidence& seen, const CompletionConfig& config);

}  // namespace colift::perception
