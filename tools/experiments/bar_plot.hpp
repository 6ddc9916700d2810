#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tools/experiments/statistics.hpp"
#include "tools/visualization/canvas.hpp"
#include "tools/visualization/line_plot.hpp"

namespace colift::experiments {

/// One column of a diagram.
struct Bar {
  std::string label;  ///< "a", "b", ... as in the thesis's figures.
  double value = 0.0;
  bool chosen = false;                        ///< Drawn in the robot's colour, and named below.
  std::optional<double> low = {}, high = {};  ///< Ends of an interval.
};

/// A part of all trials with its interval, in percent.
[[nodiscard]] Bar percent_bar(const std::string& label, const Estimate& part);

/// Columns over one axis that begins at 0; a value that is none is left out with a dash.
struct BarPanel {
  std::string title;
  std::vector<Bar> bars;
  std::vector<picture::PlotLevel> levels;  ///< A goal, a wanted value.
  std::optional<double> y_high = {};       ///< Unset: from the data.
};

/// Panels beside each other, two in a row, as in the thesis's figures 6.6, 6.9 and 6.12.
[[nodiscard]] picture::Canvas draw_bar_plot(const std::vector<BarPanel>& panels);

}  // namespace colift::experiments
