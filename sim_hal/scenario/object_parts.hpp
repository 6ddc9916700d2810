#pragma once

#include <vector>

#include "hal/types/result.hpp"
#include "sim_hal/scenario/scenario.hpp"
#include "sim_hal/synthetic/shapes.hpp"

namespace colift::sim_hal {

/// A scenario's object as solid pieces in T, for the physics and the camera alike.
struct ObjectParts {
  /// One solid piece and its mass (kg).
  struct Part {
    Shape shape;     ///< Box or cylinder; X_WS holds its pose in T.
    double mass_kg;  ///< Uniform density over all pieces, but for kind bodies.
  };
  std::vector<Part> parts;
  double mass_kg = 0.0;
  Vec3 cog_T = Vec3::Zero();                            ///< With cog_offset.
  Eigen::Matrix3d inertia_T = Eigen::Matrix3d::Zero();  ///< About cog_T (kg m^2).
};

/// Table: a 2.5 cm top on four legs. Box: a solid. Cylinder: lies along Tx on the floor, or on what its
/// clutter gives it. Chair: seat, four legs, back rest (two posts and two slats) on the side of -Ty. Bodies:
/// the pieces as given. Errors: BadConfig (sizes that make no object, centre of gravity outside of it), with
/// the scenario's entry as `where` ("object.size").
[[nodiscard]] hal::Result<ObjectParts> object_parts(const ScenarioObject& object);

/// Lowest middle point of a piece of clutter at a time of the scenario (W). A move begins where the piece is
/// at its time, also where the one before has not ended.
[[nodiscard]] Vec3 clutter_xyz(const ScenarioClutter& clutter, double t_s);

/// The clutter in W at a time of the scenario, Label::Clutter; cylinders stand upright.
[[nodiscard]] std::vector<Shape> clutter_shapes(const Scenario& scenario, double t_s = 0.0);

}  // namespace colift::sim_hal
