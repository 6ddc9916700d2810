#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tools/visualization/canvas.hpp"

namespace colift::picture {

/// A curve; NaN in y leaves a gap. x and y have the same length.
struct PlotLine {
  std::string name;
  Colour colour;
  std::vector<double> x, y;
  bool dashed = false;
  double width = 2.2;
};

/// A horizontal line with words: a limit, a wanted value.
struct PlotLevel {
  std::string name;
  double y = 0.0;
  Colour colour;
  bool dashed = true;
};

/// A stretch of x with a name, drawn behind the curves and named above them.
struct PlotBand {
  std::string name;
  double from = 0.0, to = 0.0;
  Colour colour;
};

/// One diagram with its own y axis.
struct PlotPanel {
  std::string title;  ///< What is shown, with its unit: "Load (N)".
  std::vector<PlotLine> lines;
  std::vector<PlotLevel> levels;
  std::optional<double> y_low = std::nullopt, y_high = std::nullopt;  ///< Of the axis; unset: from the data.
};

/// Diagrams one above the other over one x axis.
struct LinePlot {
  std::string x_title;
  std::vector<PlotPanel> panels;
  std::vector<PlotBand> bands;
  std::optional<double> x_low = std::nullopt, x_high = std::nullopt;
  int width = 1280, panel_height = 250;
};

[[nodiscard]] Canvas draw_line_plot(const LinePlot& plot);

/// Round values of an axis: 4 to 9 of them, steps of 1, 2 or 5 times a power of ten, inside [low, high].
[[nodiscard]] std::vector<double> axis_ticks(double low, double high, int most = 7);
/// A value beside its tick: as many digits as the step between two ticks needs.
[[nodiscard]] std::string tick_text(double value, double step);

}  // namespace colift::picture
