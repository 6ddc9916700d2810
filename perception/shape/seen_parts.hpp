#pragma once

#include "perception/shape/shape_evidence.hpp"

namespace colift::perception {

/// Whether something below a top is wider than legs: the sides of a bench, the boards of a shelf.
[[nodiscard]] bool has_panels(const ShapeEvidence& seen, const Rectangle& top,
                              const CompletionConfig& config);

/// An object of boards, sides and bars as they are seen, each as thick as the narrow faces are wide. What is
/// hidden is taken to be as on the opposite side of the middle. `top`: continued over what hid it; nullptr
/// where there is none.
[[nodiscard]] CompletedShape complete_parts(const ShapeEvidence& seen, const ShapeEvidence::Widened* top,
                                            const CompletionConfig& config);

}  // namespace colift::perception
