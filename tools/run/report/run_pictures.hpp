#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "tools/run/run_view.hpp"
#include "tools/visualization/canvas.hpp"
#include "tools/visualization/line_plot.hpp"
#include "tools/visualization/scene/scene_picture.hpp"

namespace colift::tools {

/// Scenes before and at the top of the lift: those of the simulation, else drawn from what was seen and
/// planned.
struct DrawnScenes {
  std::optional<picture::SolidScene> before, lifted;
  bool seen_only = false;  ///< Drawn from what was seen.
};
[[nodiscard]] DrawnScenes drawn_scenes(const RunView& view);

/// Where the scene in space is seen from: the camera's side of the line between both grasps (W, towards the
/// eye).
[[nodiscard]] hal::Vec3 space_direction(const RunView& view);

/// The scene in space, without walls.
[[nodiscard]] picture::Canvas space_picture(const RunView& view, const picture::SolidScene& scene, int width,
                                            int height);

/// Before and at the top from the side; nullopt without both scenes or without a grasp.
[[nodiscard]] std::optional<picture::Canvas> side_picture(const RunView& view, const DrawnScenes& scenes);

/// Distance of people to the arm and the arm's speed over time; nullopt when nobody was near.
[[nodiscard]] std::optional<picture::LinePlot> separation_plot(const RunView& view);

/// Every cell of the tactile arrays when the grip was judged; nullopt for a hand without them.
[[nodiscard]] std::optional<picture::Canvas> tactile_picture(const control::RunRecord& record);
/// How well the closed hand held, in sentences; empty when it was not closed.
[[nodiscard]] std::vector<std::string> grip_sentences(const control::RunRecord& record);

/// Load, share, tilt, height and slip over time with the states behind them; nullopt without curves.
[[nodiscard]] std::optional<picture::LinePlot> curves_plot(const RunView& view);

}  // namespace colift::tools
