#pragma once

#include <vector>

#include "hal/config/range.hpp"
#include "perception/scene.hpp"
#include "planner/hand/leg_face.hpp"
#include "planner/hand/seen_space.hpp"

namespace colift::planner {

/// When two faces imply a solid behind them.
struct SolidConfig {
  double perpendicular_cosine = 0.94;
  int samples_per_side = 6;
  LegFaceConfig leg;

  template <class Visitor>
  void visit(Visitor& v) {
    v("perpendicular_cosine", perpendicular_cosine, hal::kFraction,
      "Min cosine between a face's outward edge and the normal of the face that adjoins there (0.94: 20 "
      "degrees).");
    v("samples_per_side", samples_per_side, hal::Range{1, 100},
      "Number of places along each side of an implied solid at which the view is tested.");
    v("leg", leg, "When a face below a plate is that of a leg.");
  }
};

/// An edge of a rectangle: outward direction in the rectangle's plane, and its two ends.
struct RectangleEdge {
  Vec3 outward = Vec3::Zero();
  Vec3 from = Vec3::Zero();
  Vec3 to = Vec3::Zero();
};
[[nodiscard]] std::vector<RectangleEdge> edges_of(const perception::Rectangle& rectangle);

/// Distance of a point from a rectangle's area (m).
[[nodiscard]] double distance_to(const perception::Rectangle& rectangle, const Vec3& p);

/// True when rectangle b is perpendicular to rectangle a and faces outwards at this edge of a. Where it also
/// passes near the edge, it closes the body there.
[[nodiscard]] bool faces_out(const RectangleEdge& edge_of_a, const perception::Rectangle& b,
                             const SolidConfig& config = {});

/// The box that two faces imply when they meet at a convex edge: as long as both are along the edge, as deep
/// as each is seen to be from the other.
struct CompletedSolid {
  int a = -1, b = -1;  ///< Surfaces that imply it; -1: the mirrored place of a leg that was seen.
  hal::OrientedBox box;

  /// Extent along a unit vector that is (nearly) one of the box's axes (m).
  [[nodiscard]] double extent_along(const Vec3& direction) const;
};

using CompletedSolids = std::vector<CompletedSolid>;

/// Boxes implied by pairs of adjoining rectangles. A box into which the camera looked (an open box, whose
/// walls imply a full one) is dropped when more than `max_free` of it was seen to be free. A plate with a leg
/// has legs at the mirrored places, too, where the camera does not see that there is none.
[[nodiscard]] CompletedSolids complete_solids(const perception::Scene& scene, const SeenSpace* seen,
                                              double tolerance_m, double max_free,
                                              const SolidConfig& config = {});

}  // namespace colift::planner
