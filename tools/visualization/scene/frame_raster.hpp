#pragma once

#include <cstdint>
#include <vector>

#include "tools/visualization/scene/scene_picture.hpp"

namespace colift::picture {

/// The frame of a picture as RGB bytes, `scale` times as large: shaded (with the colours of the camera where
/// it has them), ground tinted with a metric grid where it is seen, target and changed pixels tinted and
/// outlined, missing depth dark.
[[nodiscard]] std::vector<std::uint8_t> frame_raster(const ScenePicture& what, int scale);

/// Spacing of the ground's grid that suits a camera this high above it (m).
[[nodiscard]] double grid_step_m(double camera_height_m);

/// Which pixels of the cloud show the target: those it names, else those that its points fall on. One byte
/// each.
[[nodiscard]] std::vector<std::uint8_t> target_mask(const perception::OrganisedCloud& cloud,
                                                    const perception::Target& target);

}  // namespace colift::picture
