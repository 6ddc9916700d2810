#pragma once

#include "hal/config/range.hpp"
#include "perception/noise_model.hpp"
#include "perception/scene.hpp"
#include "perception/target/regions/fragments.hpp"

namespace colift::perception {

/// On which pieces of an object's surface its curvature is measured.
struct CurvatureConfig {
  double half_width_m = 0.03;
  double max_residual = 1.7;
  double convex_per_m = 4.0;

  template <class Visitor>
  void visit(Visitor& v) {
    v("half_width_m", half_width_m, hal::kPositive,
      "Half the side of the square pieces on which curvature is measured (m).");
    v("max_residual", max_residual, hal::kPositive,
      "Max root mean square residual of a piece, in standard deviations of the depth noise; others have an "
      "edge or a step.");
    v("convex_per_m", convex_per_m, hal::kPositive, "Min curvature of a piece that counts as convex (1/m).");
  }
};

/// How round the visible surface of an object is. A plane has curvature 0, a cylinder 1 / radius, a sphere
/// 2 / radius.
struct SurfaceCurvature {
  double median_per_m = 0.0;  ///< Sum of the principal curvatures, positive where convex (1/m).
  double sigma_per_m = 0.0;   ///< Standard deviation of that median by the depth noise (1/m).
  double convex = 0.0;        ///< Fraction of the pieces that are convex.
  double measured = 0.0;      ///< Fraction of the object's pixels around which a piece could be measured.
  int pieces = 0;             ///< 0: nothing is known.
};

/// Curvature over pieces that lie wholly on the object, by least-squares fits of its inverse depth: planes
/// are linear in it over the image, so that a slanted one is not taken for a round one.
[[nodiscard]] SurfaceCurvature surface_curvature(const OrganisedCloud& cloud, const Components& components,
                                                 const Fragment& object, const NoiseModel& noise,
                                                 const CurvatureConfig& config = {});

}  // namespace colift::perception
