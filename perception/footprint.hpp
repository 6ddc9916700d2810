#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "hal/config/range.hpp"
#include "hal/types/geometry.hpp"

namespace colift::perception {

/// Corners of the convex hull of points in a plane, counter-clockwise, starting at the smallest x (then y),
/// without corners on a straight edge. One corner for equal points, two for points on a line, none for no
/// points. Points must be finite. Monotone chain (Andrew 1979) after dropping points inside an octagon of
/// extreme points (Akl, Toussaint 1978), so that a dense blob of n points costs little more than one pass.
[[nodiscard]] std::vector<Eigen::Vector2d> convex_hull(std::span<const Eigen::Vector2d> points);

/// A rectangle in a plane: size.x() >= size.y(), the longer side along the unit vector u, which points to
/// positive x (or to positive y where x is 0).
struct FlatRectangle {
  Eigen::Vector2d center = Eigen::Vector2d::Zero();
  Eigen::Vector2d u = Eigen::Vector2d::UnitX();
  Eigen::Vector2d size = Eigen::Vector2d::Zero();

  [[nodiscard]] Eigen::Vector2d v() const { return {-u.y(), u.x()}; }
  [[nodiscard]] double area() const { return size.x() * size.y(); }
};

/// The rectangle of least area around a hull as convex_hull() returns it: one side lies on a hull edge
/// (Freeman, Shapira 1975), found in one turn of the calipers (Toussaint 1983). Without corners the centre is
/// NaN.
[[nodiscard]] FlatRectangle minimum_area_rectangle(std::span<const Eigen::Vector2d> hull);

/// The box that stands upright on a plane around points: footprint of least area, height from the lowest to
/// the highest point. Axes are (long side, short side, plane normal). Points must be finite; without points
/// the centre is NaN.
[[nodiscard]] hal::OrientedBox box_on_plane(std::span<const Eigen::Vector3f> points,
                                            const hal::Plane& ground);

/// What a box may leave out as strays. Meant for full-resolution points: where more than half of the points
/// lie in sparse cells, as in a cloud thinned to one point per cell, the footprint keeps them all.
struct BoxTrim {
  double quantile = 0.003;  ///< Part of the points that may lie below, and as much above, the height range.
  double cell_m = 0.01;     ///< Side of the footprint's cells; wider where 4096 cells do not span the object.
  int cell_points = 3;      ///< Cells with fewer points do not count for the footprint.
  double side_cells =
      0.008;  ///< Part of the footprint's cells that may lie beyond each of its sides: a thin tip.

  template <class Visitor>
  void visit(Visitor& v) {
    v("quantile", quantile, hal::Range{0, 0.49},
      "Fraction of the points that may lie below, and as many above, the height range.");
    v("cell_m", cell_m, hal::Range{0.001, 0.5}, "Side of the cells of the footprint (m).");
    v("cell_points", cell_points, hal::Range{1, 1000}, "Min number of points of a cell of the footprint.");
    v("side_cells", side_cells, hal::Range{0, 0.49},
      "Fraction of the footprint's cells that may lie beyond each of its sides.");
  }
};

/// As above, without strays.
[[nodiscard]] hal::OrientedBox box_on_plane(std::span<const Eigen::Vector3f> points, const hal::Plane& ground,
                                            const BoxTrim& trim);

}  // namespace colift::perception
