#include "tools/visualization/palette.hpp"

#include <cmath>
#include <numbers>

namespace colift::picture {
namespace {

std::vector<Px> polygon(const Px& at, double radius, int corners, double first_rad) {
  std::vector<Px> points;
  for (int i = 0; i < corners; ++i) {
    const double angle = first_rad + 2 * std::numbers::pi * i / corners;
    points.push_back(at + radius * Px(std::cos(angle), std::sin(angle)));
  }
  return points;
}

}  // namespace

void draw_mark(Canvas& canvas, const Px& at, double radius, MarkShape shape, const Colour& colour) {
  constexpr double kUp = -std::numbers::pi / 2;
  const Stroke rim{.colour = kWhite, .width = 1.4};
  const auto filled = [&](const std::vector<Px>& points) {
    canvas.fill(points, colour);
    canvas.polyline(points, true, rim);
  };
  switch (shape) {
    case MarkShape::Disc:
      canvas.disc(at, radius + 1.2, kWhite);
      canvas.disc(at, radius, colour);
      return;
    case MarkShape::Cross: {
      const double d = 0.8 * radius;
      const Stroke arm{.colour = colour, .width = 0.55 * radius, .halo = kWhite, .halo_width = 1.2};
      const Stroke top{.colour = colour, .width = 0.55 * radius};
      canvas.line(at + Px(-d, -d), at + Px(d, d), arm);
      canvas.line(at + Px(-d, d), at + Px(d, -d), arm);
      canvas.line(at + Px(-d, -d), at + Px(d, d), top);
      return;
    }
    case MarkShape::Ring:
      canvas.circle(at, 0.8 * radius,
                    {.colour = colour, .width = 0.5 * radius, .halo = kWhite, .halo_width = 1.2});
      return;
    case MarkShape::Square:
      filled(polygon(at, 1.25 * radius, 4, std::numbers::pi / 4));
      return;
    case MarkShape::Triangle:
      filled(polygon(at, 1.35 * radius, 3, kUp));
      return;
    case MarkShape::Diamond:
      filled(polygon(at, 1.3 * radius, 4, kUp));
      return;
    case MarkShape::Dotted:
      canvas.disc(at, radius + 1.2, kWhite);
      canvas.disc(at, radius, colour);
      canvas.disc(at, 0.4 * radius, kWhite);
      return;
  }
}

void draw_ball(Canvas& canvas, const Px& at, double radius, const Colour& colour) {
  canvas.disc(at, radius + 3.0, kWhite);
  canvas.disc(at, radius + 1.2, kInk);
  canvas.disc(at, radius, colour);
  canvas.disc(at + Px(-0.38 * radius, -0.42 * radius), 0.24 * radius, kWhite.with_alpha(0.85));
}

void draw_optimum(Canvas& canvas, const Px& at, double radius) {
  const Stroke arm{.colour = kOptimum, .width = 2.4, .halo = kWhite, .halo_width = 2.2};
  const Stroke top{.colour = kOptimum, .width = 2.4};
  canvas.line(at - Px(radius, 0), at + Px(radius, 0), arm);
  canvas.line(at - Px(0, radius), at + Px(0, radius), arm);
  canvas.line(at - Px(radius, 0), at + Px(radius, 0), top);
}

}  // namespace colift::picture
