#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "hal/types/result.hpp"

namespace colift::picture {

/// A place on a canvas in pixels: x to the right, y down, (0, 0) is the corner of the top left pixel.
using Px = Eigen::Vector2d;

/// Red, green, blue and opacity, each 0 to 1.
struct Colour {
  double r = 0.0, g = 0.0, b = 0.0, a = 1.0;

  [[nodiscard]] constexpr Colour with_alpha(double alpha) const { return {r, g, b, alpha}; }
  /// This colour moved towards another one; t = 0 stays, t = 1 arrives.
  [[nodiscard]] constexpr Colour towards(const Colour& o, double t) const {
    return {r + t * (o.r - r), g + t * (o.g - g), b + t * (o.b - b), a + t * (o.a - a)};
  }
};

/// A colour from its usual notation 0xRRGGBB.
[[nodiscard]] constexpr Colour rgb(std::uint32_t hex) {
  return {((hex >> 16) & 255u) / 255.0, ((hex >> 8) & 255u) / 255.0, (hex & 255u) / 255.0, 1.0};
}

/// An upright rectangle on the canvas (px).
struct Box {
  double x = 0.0, y = 0.0, width = 0.0, height = 0.0;

  [[nodiscard]] double right() const { return x + width; }
  [[nodiscard]] double bottom() const { return y + height; }
  [[nodiscard]] Px center() const { return {x + width / 2, y + height / 2}; }
  [[nodiscard]] bool contains(const Px& p) const {
    return p.x() >= x && p.y() >= y && p.x() <= right() && p.y() <= bottom();
  }
  [[nodiscard]] bool overlaps(const Box& o) const {
    return x < o.right() && o.x < right() && y < o.bottom() && o.y < bottom();
  }
  [[nodiscard]] Box grown(double by) const { return {x - by, y - by, width + 2 * by, height + 2 * by}; }
};

/// How a line is drawn.
struct Stroke {
  Colour colour;
  double width = 1.0;
  std::vector<double> dashes = {};  ///< Lengths on, off, on, ... (px); empty for a solid line.
  Colour halo = {0, 0, 0, 0};       ///< A wider line beneath, so that the line shows on any ground.
  double halo_width = 2.0;          ///< On either side (px).
};

enum class Align { Left, Middle, Right };

/// How a text is drawn.
struct TextStyle {
  double size = 16.0;  ///< Em (px).
  Colour colour = {0.1, 0.1, 0.1, 1.0};
  bool bold = false;
  Align align = Align::Left;
  Colour halo = {0, 0, 0, 0};
};

/// An image in memory that is drawn on with antialiased shapes. Needs neither window system nor GPU.
class Canvas {
 public:
  /// Sizes in pixels; brought into 1 to 32767, the most that cairo can.
  Canvas(int width, int height, const Colour& background);
  ~Canvas();
  Canvas(Canvas&&) noexcept;
  Canvas& operator=(Canvas&&) noexcept;

  [[nodiscard]] int width() const;
  [[nodiscard]] int height() const;

  void line(const Px& from, const Px& to, const Stroke& stroke);
  void polyline(const std::vector<Px>& points, bool closed, const Stroke& stroke);
  void fill(const std::vector<Px>& polygon, const Colour& colour);
  void fill(const Box& box, const Colour& colour, double corner_radius = 0.0);
  void outline(const Box& box, const Stroke& stroke, double corner_radius = 0.0);
  void disc(const Px& center, double radius, const Colour& colour);
  void circle(const Px& center, double radius, const Stroke& stroke);

  /// Ellipse with half axes `half_axes` (columns, px), for example from ellipse_of().
  void ellipse(const Px& center, const Eigen::Matrix2d& half_axes, const Colour& inside,
               const Stroke& stroke);

  /// One line of text, UTF-8. `at` is the baseline's left end, middle or right end.
  void text(const Px& at, const std::string& words, const TextStyle& style);

  /// Advance width of one line of text (px).
  [[nodiscard]] double text_width(const std::string& words, const TextStyle& style) const;

  /// Breaks text into lines no wider than `width`: at spaces, at line ends of its own, and inside words that
  /// alone are too wide.
  [[nodiscard]] std::vector<std::string> wrap(const std::string& words, double width,
                                              const TextStyle& style) const;

  /// Copies an opaque image, 3 bytes for each pixel, without scaling.
  void image(int x, int y, int image_width, int image_height, const std::vector<std::uint8_t>& rgb_bytes);

  /// Until the end of its life, what is drawn stays inside the box.
  class Clip {
   public:
    Clip(Canvas& canvas, const Box& box);
    ~Clip();
    Clip(const Clip&) = delete;
    Clip& operator=(const Clip&) = delete;

   private:
    Canvas& canvas_;
  };

  /// Colour of one pixel.
  [[nodiscard]] Colour at(int x, int y) const;

  /// Every pixel, 3 bytes each, row-major.
  [[nodiscard]] std::vector<std::uint8_t> rgb_bytes() const;

  /// The picture as the bytes of a PNG file.
  [[nodiscard]] std::vector<std::uint8_t> png() const;

  /// Errors: BadInput when the file cannot be written; an older file of that name is then still whole.
  [[nodiscard]] hal::Result<> write_png(const std::filesystem::path& file) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Half axes of the ellipse at `sigmas` standard deviations of a 2-D covariance (px^2).
[[nodiscard]] Eigen::Matrix2d ellipse_of(const Eigen::Matrix2d& covariance, double sigmas);

}  // namespace colift::picture
