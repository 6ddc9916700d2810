#pragma once

#include <filesystem>

#include "tools/visualization/canvas.hpp"
#include "tools/visualization/scene/scene_picture.hpp"

namespace colift::picture {

/// The scene from straight above, to scale, with the camera at the lower side: where both agents grasp,
/// where the weight hangs between them, and how long their levers are. Draws only inside `area`.
void draw_top_view(Canvas& canvas, const Box& area, const ScenePicture& what);

/// Whether there is anything to draw.
[[nodiscard]] bool has_top_view(const ScenePicture& what);

/// The top view alone as a square PNG. Errors: BadInput when the file cannot be written.
[[nodiscard]] hal::Result<> write_top_view(const std::filesystem::path& png, const ScenePicture& what,
                                           int side_px = 900);

}  // namespace colift::picture
