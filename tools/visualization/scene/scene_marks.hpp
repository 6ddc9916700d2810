#pragma once

#include <vector>

#include "tools/visualization/labels.hpp"
#include "tools/visualization/scene/camera_view.hpp"
#include "tools/visualization/scene/scene_picture.hpp"

namespace colift::picture {

/// Everything that is drawn over the frame, from what is least to what matters most. Clipped to the frame.
void draw_marks(Canvas& canvas, const CameraView& view, const ScenePicture& what);

/// The candidate that was chosen, or null.
[[nodiscard]] const planner::GraspCandidate* chosen_of(const ScenePicture& what);

/// The target, or null.
[[nodiscard]] const perception::Target* target_of(const ScenePicture& what);

/// The ground's normal, else a guess from the camera: against its Cy.
[[nodiscard]] Vec3 up_of(const ScenePicture& what);

}  // namespace colift::picture
