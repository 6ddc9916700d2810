#include "tools/experiments/bar_plot.hpp"

#include <algorithm>
#include <cmath>

#include "tools/visualization/palette.hpp"

namespace colift::experiments {
namespace {

using namespace picture;

constexpr double kWidth = 620, kHeight = 380, kLeft = 66, kRight = 18, kTop = 54, kBottom = 58;

void draw_panel(Canvas& canvas, const Px& corner, const BarPanel& panel) {
  const Box area{corner.x() + kLeft, corner.y() + kTop, kWidth - kLeft - kRight, kHeight - kTop - kBottom};
  double high = 0.0;
  for (const Bar& bar : panel.bars) {
    if (std::isfinite(bar.value)) high = std::max(high, bar.value);
    if (bar.high && std::isfinite(*bar.high)) high = std::max(high, *bar.high);
  }
  for (const PlotLevel& level : panel.levels) high = std::max(high, level.y);
  high = panel.y_high.value_or(high > 0.0 ? 1.12 * high : 1.0);
  const auto py = [&](double y) { return area.bottom() - std::clamp(y / high, 0.0, 1.0) * area.height; };

  canvas.text({corner.x() + 14, corner.y() + 30}, panel.title, {.size = 17, .colour = kInk, .bold = true});
  const std::vector<double> ticks = axis_ticks(0.0, high, 6);
  const double step = ticks.size() > 1 ? ticks[1] - ticks[0] : 1.0;
  for (const double t : ticks) {
    canvas.line({area.x, py(t)}, {area.right(), py(t)}, {.colour = kRule, .width = 1});
    canvas.text({area.x - 8, py(t) + 5}, tick_text(t, step),
                {.size = 14, .colour = kSoftInk, .align = Align::Right});
  }
  const double each = area.width / std::max<std::size_t>(1, panel.bars.size());
  const double wide = std::min(0.62 * each, 64.0);
  for (std::size_t i = 0; i < panel.bars.size(); ++i) {
    const Bar& bar = panel.bars[i];
    const double x = area.x + (static_cast<double>(i) + 0.5) * each;
    const TextStyle under{.size = 15, .colour = kInk, .bold = bar.chosen, .align = Align::Middle};
    canvas.text({x, area.bottom() + 21}, bar.label, under);
    if (bar.chosen)
      canvas.text({x, area.bottom() + 40}, "chosen", {.size = 13, .colour = kRobot, .align = Align::Middle});
    if (!std::isfinite(bar.value)) {
      canvas.text({x, area.bottom() - 6}, "\u2013", {.size = 16, .colour = kSoftInk, .align = Align::Middle});
      continue;
    }
    const double top = py(bar.value);
    canvas.fill(Box{x - wide / 2, top, wide, area.bottom() - top},
                bar.chosen ? kRobot : kPartner.towards(kWhite, 0.35));
    if (bar.low && bar.high) {
      const Stroke ink{.colour = kInk, .width = 1.6};
      canvas.line({x, py(*bar.low)}, {x, py(*bar.high)}, ink);
      for (const double y : {*bar.low, *bar.high}) canvas.line({x - 7, py(y)}, {x + 7, py(y)}, ink);
    }
  }
  canvas.line({area.x, area.bottom()}, {area.right(), area.bottom()}, {.colour = kInk, .width = 1.5});
  for (const PlotLevel& level : panel.levels) {
    Stroke stroke{.colour = level.colour, .width = 1.8};
    if (level.dashed) stroke.dashes = {7, 5};
    canvas.line({area.x, py(level.y)}, {area.right(), py(level.y)}, stroke);
    canvas.text({area.right() - 4, py(level.y) - 6}, level.name,
                {.size = 13,
                 .colour = level.colour.towards(kInk, 0.35),
                 .align = Align::Right,
                 .halo = kPaper.with_alpha(0.8)});
  }
}

}  // namespace

Bar percent_bar(const std::string& label, const Estimate& part) {
  return {label, 100.0 * part.value, false, 100.0 * part.low, 100.0 * part.high};
}

picture::Canvas draw_bar_plot(const std::vector<BarPanel>& panels) {
  const std::size_t columns = panels.size() > 1 ? 2 : 1;
  const std::size_t rows = std::max<std::size_t>(1, (panels.size() + columns - 1) / columns);
  Canvas canvas(static_cast<int>(static_cast<double>(columns) * kWidth),
                static_cast<int>(static_cast<double>(rows) * kHeight), kPaper);
  for (std::size_t i = 0; i < panels.size(); ++i)
    draw_panel(canvas,
               {static_cast<double>(i % columns) * kWidth, static_cast<double>(i / columns) * kHeight},
               panels[i]);
  return canvas;
}

}  // namespace colift::experiments
