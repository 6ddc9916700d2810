#pragma once

#include "tools/visualization/canvas.hpp"
#include "tools/visualization/scene/scene_picture.hpp"

namespace colift::picture {

/// Title, reason, load share and key figures, one beneath the other. Returns the y where they end; without
/// `draw` nothing is drawn, to know the height beforehand.
double draw_panel(Canvas& canvas, const Box& area, const ScenePicture& what, bool draw);

/// Legend of all marks that occur, with counts, then the notes. Returns the y where they end, as above.
double draw_legend(Canvas& canvas, const Box& area, const ScenePicture& what, bool draw);

}  // namespace colift::picture
