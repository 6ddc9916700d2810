#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "hal/types/geometry.hpp"
#include "hal/types/result.hpp"
#include "perception/noise_model.hpp"
#include "perception/organised_cloud.hpp"
#include "tools/scenes/scene_file.hpp"

namespace colift::tools {

/// What differences between the steps show, without anything that looks for grounds, objects or persons: what
/// perception says of the scene is held against it. Pixels are row-major; points are in the camera's optical
/// frame.
struct SceneTruth {
  perception::OrganisedCloud object;  ///< Median of the step's images; NaN where most saw nothing.
  std::vector<bool> object_pixels;    ///< Nearer than in the empty place.
  std::vector<bool> person_pixels;    ///< Nearer with the person than with the object alone.
  std::size_t object_count = 0;       ///< Pixels of the object.
  /// Where the person is within 4 cm of being nearest to the object, the middle of each such place, largest
  /// first: hands, and a leg that leans on it. One alone where the scene's file points at it.
  std::vector<hal::Vec3> hands;
  double moved = 0.0;  ///< Part of the object's pixels beside the person that changed from the hand's step to
                       ///< the last image (0 to 1).
};

/// Errors: NotFound, with what to record anew: nothing new or several new things, the camera moved, nobody at
/// the object, the object was not moved.
[[nodiscard]] hal::Result<SceneTruth> scene_truth(const RecordedSteps& scene,
                                                  const perception::NoiseModel& noise);

}  // namespace colift::tools
