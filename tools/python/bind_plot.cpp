// Line plots in the style of the program's reports, so that scripts need no plotting package.
#include <cmath>

#include "tools/python/bindings.hpp"
#include "tools/visualization/line_plot.hpp"
#include "tools/visualization/palette.hpp"

namespace colift::python {
namespace {

using Curve = std::tuple<std::string, std::vector<double>, std::vector<double>>;  // name, x, y
using Level = std::pair<std::string, double>;
using Panel = std::tuple<std::string, std::vector<Curve>, std::vector<Level>>;

constexpr std::size_t kMostPanels = 20;
constexpr double kLargest = 1e12;  // of a value that an axis is made for
constexpr picture::Colour kSeries[] = {picture::kPartner, picture::kRobot, picture::kCog, picture::kAxisX,
                                       picture::kSoftInk};

void check(const std::string& name, const std::vector<double>& x, const std::vector<double>& y) {
  if (x.size() != y.size()) refuse("panels", name + ": x and y have different lengths");
  for (const double v : x)
    if (!(std::abs(v) <= kLargest)) refuse("panels", name + ": x has to be finite, up to 1e12");
  for (const double v : y)
    if (std::abs(v) > kLargest) refuse("panels", name + ": y goes up to 1e12; NaN leaves a gap");
}

void write_plot(const std::string& file, const std::string& x_title, const std::vector<Panel>& panels) {
  if (panels.empty() || panels.size() > kMostPanels) refuse("panels", "expected 1 to 20 of them");
  picture::LinePlot plot;
  plot.x_title = x_title;
  for (const auto& [title, curves, levels] : panels) {
    picture::PlotPanel panel;
    panel.title = title;
    for (const auto& [name, x, y] : curves) {
      check(name, x, y);
      picture::PlotLine line;
      line.name = name;
      line.colour = kSeries[panel.lines.size() % std::size(kSeries)];
      line.x = x;
      line.y = y;
      panel.lines.push_back(std::move(line));
    }
    for (const auto& [name, y] : levels) {
      check(name, {y}, {y});
      panel.levels.push_back({name, y, picture::kInk});
    }
    plot.panels.push_back(std::move(panel));
  }
  value_of(picture::draw_line_plot(plot).write_png(file));
}

}  // namespace

void bind_plot(py::module_& m) {
  m.def("write_plot", &write_plot, py::arg("file"), py::arg("x_title"), py::arg("panels"),
        py::call_guard<Unlocked>());
}

}  // namespace colift::python
