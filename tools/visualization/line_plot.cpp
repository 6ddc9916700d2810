#include "tools/visualization/line_plot.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "tools/visualization/palette.hpp"

namespace colift::picture {
namespace {

constexpr double kLeft = 76, kRight = 28, kTitle = 40, kGap = 22, kBandNames = 30, kFoot = 62, kLegend = 24;

struct Span {
  double low = std::numeric_limits<double>::infinity(), high = -std::numeric_limits<double>::infinity();

  void take(double v) {
    if (!std::isfinite(v)) return;
    low = std::min(low, v);
    high = std::max(high, v);
  }
  [[nodiscard]] bool empty() const { return low > high; }
};

Span x_span(const LinePlot& plot) {
  Span span;
  for (const PlotPanel& panel : plot.panels)
    for (const PlotLine& line : panel.lines)
      for (const double x : line.x) span.take(x);
  for (const PlotBand& band : plot.bands) {
    span.take(band.from);
    span.take(band.to);
  }
  if (plot.x_low) span.low = *plot.x_low;
  if (plot.x_high) span.high = *plot.x_high;
  if (!(span.low < span.high)) span = {span.empty() ? 0.0 : span.low, (span.empty() ? 0.0 : span.low) + 1.0};
  return span;
}

Span y_span(const PlotPanel& panel) {
  Span span;
  for (const PlotLine& line : panel.lines)
    for (const double y : line.y) span.take(y);
  for (const PlotLevel& level : panel.levels) span.take(level.y);
  if (span.empty()) span = {0.0, 1.0};
  const double room =
      span.high > span.low ? 0.08 * (span.high - span.low) : std::max(0.1, std::abs(span.high));
  // an axis that begins at zero stays there
  const bool from_zero = span.low >= 0.0 && span.low < 0.4 * span.high;
  span = {from_zero ? 0.0 : span.low - room, span.high + room};
  if (panel.y_low) span.low = *panel.y_low;
  if (panel.y_high) span.high = *panel.y_high;
  if (!(span.low < span.high)) span.high = span.low + 1.0;
  return span;
}

class Panel {
 public:
  Panel(Canvas& canvas, const Box& area, const Span& x, const PlotPanel& what)
      : canvas_(canvas), area_(area), x_(x), y_(y_span(what)), what_(what) {}

  void draw(const std::vector<PlotBand>& bands) {
    canvas_.fill(area_, kPaper);
    draw_bands(bands);
    draw_axes();
    {
      const Canvas::Clip inside(canvas_, area_.grown(2));
      for (const PlotLevel& level : what_.levels) draw_level(level);
      for (const PlotLine& line : what_.lines) draw_line(line);
    }
    canvas_.outline(area_, {.colour = kRule, .width = 1.2});
    // names of levels last, where they can be read
    for (const PlotLevel& level : what_.levels) name_level(level);
    draw_title();
  }

 private:
  [[nodiscard]] double px(double x) const {
    return area_.x + (x - x_.low) / (x_.high - x_.low) * area_.width;
  }
  [[nodiscard]] double py(double y) const {
    return area_.bottom() - (y - y_.low) / (y_.high - y_.low) * area_.height;
  }

  void draw_bands(const std::vector<PlotBand>& bands) {
    const Canvas::Clip inside(canvas_, area_);
    for (const PlotBand& band : bands) {
      const double from = px(std::max(band.from, x_.low)), to = px(std::min(band.to, x_.high));
      if (to > from) canvas_.fill(Box{from, area_.y, to - from, area_.height}, band.colour);
    }
  }

  void draw_axes() {
    const Stroke grid{.colour = rgb(0x9AA5B1).with_alpha(0.35), .width = 1.0};
    const std::vector<double> ys = axis_ticks(y_.low, y_.high, 6);
    for (const double y : ys) {
      canvas_.line({area_.x, py(y)}, {area_.right(), py(y)}, grid);
      canvas_.text({area_.x - 9, py(y) + 5}, tick_text(y, ys.size() > 1 ? ys[1] - ys[0] : 1.0),
                   {.size = 15, .colour = kSoftInk, .align = Align::Right});
    }
    for (const double x : axis_ticks(x_.low, x_.high, 12))
      canvas_.line({px(x), area_.y}, {px(x), area_.bottom()}, grid);
  }

  void draw_level(const PlotLevel& level) {
    Stroke stroke{.colour = level.colour, .width = 1.8};
    if (level.dashed) stroke.dashes = {8, 6};
    canvas_.line({area_.x, py(level.y)}, {area_.right(), py(level.y)}, stroke);
  }

  // Above its line at the right end, beneath it where there is no room above.
  void name_level(const PlotLevel& level) {
    if (!(level.y >= y_.low && level.y <= y_.high)) return;
    const double y = py(level.y);
    canvas_.text({area_.right() - 8, y - 6 > area_.y + 12 ? y - 6 : y + 17}, level.name,
                 {.size = 14,
                  .colour = level.colour.towards(kInk, 0.35),
                  .align = Align::Right,
                  .halo = kPaper.with_alpha(0.8)});
  }

  void draw_line(const PlotLine& line) {
    std::vector<Px> piece;
    const auto flush = [&] {
      Stroke stroke{.colour = line.colour, .width = line.width};
      if (line.dashed) stroke.dashes = {7, 5};
      if (piece.size() > 1) canvas_.polyline(piece, false, stroke);
      if (piece.size() == 1) canvas_.disc(piece[0], 0.7 * line.width, line.colour);
      piece.clear();
    };
    for (std::size_t i = 0; i < std::min(line.x.size(), line.y.size()); ++i) {
      if (std::isfinite(line.x[i]) && std::isfinite(line.y[i]))
        piece.emplace_back(px(line.x[i]), std::clamp(py(line.y[i]), area_.y - 50, area_.bottom() + 50));
      else
        flush();
    }
    flush();
  }

  void draw_title() {
    const double y = area_.y - 12;
    const TextStyle style{.size = 17, .colour = kInk, .bold = true};
    canvas_.text({area_.x, y}, what_.title, style);
    // the legend runs from the right, so that it never meets the title's end
    double x = area_.right();
    const TextStyle name{.size = 15, .colour = kInk};
    for (auto line = what_.lines.rbegin(); line != what_.lines.rend(); ++line) {
      x -= canvas_.text_width(line->name, name);
      canvas_.text({x, y}, line->name, name);
      Stroke stroke{.colour = line->colour, .width = std::max(2.4, line->width)};
      if (line->dashed) stroke.dashes = {7, 4};
      canvas_.line({x - 8 - kLegend, y - 5}, {x - 8, y - 5}, stroke);
      x -= kLegend + 8 + 24;
    }
  }

  Canvas& canvas_;
  Box area_;
  Span x_, y_;
  const PlotPanel& what_;
};

void name_bands(Canvas& canvas, const Box& area, const Span& x, const std::vector<PlotBand>& bands) {
  const TextStyle style{.size = 14, .colour = kSoftInk, .align = Align::Middle};
  double taken = area.x - 40;
  for (const PlotBand& band : bands) {
    const double from = std::max(band.from, x.low), to = std::min(band.to, x.high);
    if (!(to > from)) continue;
    const double middle = area.x + (0.5 * (from + to) - x.low) / (x.high - x.low) * area.width;
    const double half = 0.5 * canvas.text_width(band.name, style);
    // a name too long for its band still shows where its neighbours leave room
    if (middle - half < taken + 6 || middle + half > area.right() + kRight) continue;
    canvas.text({middle, area.y}, band.name, style);
    taken = middle + half;
  }
}

}  // namespace

std::vector<double> axis_ticks(double low, double high, int most) {
  if (!std::isfinite(low) || !std::isfinite(high) || !(low < high)) return {};
  const double rough = (high - low) / std::max(2, most);
  const double decade = std::pow(10.0, std::floor(std::log10(rough)));
  double step = 10 * decade;
  for (const double factor : {5.0, 2.0, 1.0})
    if (factor * decade >= rough) step = factor * decade;
  std::vector<double> ticks;
  for (double i = std::ceil(low / step - 1e-9); i * step <= high + 1e-9 * step; ++i)
    ticks.push_back(i * step);
  return ticks;
}

std::string tick_text(double value, double step) {
  const int digits = step >= 1 ? 0 : std::clamp(static_cast<int>(std::ceil(-std::log10(step) - 1e-9)), 0, 6);
  // no minus before a zero
  return fmt::format("{:.{}f}", std::abs(value) < 1e-9 * step ? 0.0 : value, digits);
}

Canvas draw_line_plot(const LinePlot& plot) {
  const auto panels = static_cast<double>(plot.panels.size());
  const double names = plot.bands.empty() ? 0 : kBandNames;
  const double height = names + panels * (kTitle + plot.panel_height + kGap) + kFoot - kGap;
  Canvas canvas(plot.width, static_cast<int>(std::ceil(height)), kPaper);
  const Span x = x_span(plot);
  double y = names;
  const double width = plot.width - kLeft - kRight;
  if (names > 0) name_bands(canvas, Box{kLeft, 22, width, 0}, x, plot.bands);
  for (const PlotPanel& panel : plot.panels) {
    y += kTitle;
    Panel(canvas, Box{kLeft, y, width, static_cast<double>(plot.panel_height)}, x, panel).draw(plot.bands);
    y += plot.panel_height + kGap;
  }
  y -= kGap;
  const std::vector<double> ticks = axis_ticks(x.low, x.high, 12);
  for (const double t : ticks)
    canvas.text({kLeft + (t - x.low) / (x.high - x.low) * width, y + 21},
                tick_text(t, ticks.size() > 1 ? ticks[1] - ticks[0] : 1.0),
                {.size = 15, .colour = kSoftInk, .align = Align::Middle});
  canvas.text({kLeft + 0.5 * width, y + 45}, plot.x_title,
              {.size = 15, .colour = kSoftInk, .align = Align::Middle});
  return canvas;
}

}  // namespace colift::picture
