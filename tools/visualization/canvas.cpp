#include "tools/visualization/canvas.hpp"

#include <cairo.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tools/visualization/file_output.hpp"
#include "tools/visualization/utf8.hpp"

#if defined(__SANITIZE_ADDRESS__)
// fontconfig keeps its patterns behind encoded offsets, where the leak checker cannot see that they are in
// use
extern "C" __attribute__((weak)) const char* __lsan_default_suppressions() {
  return "leak:libfontconfig";
}
extern "C" __attribute__((weak)) const char* __lsan_default_options() {
  return "print_suppressions=0";
}
#endif

namespace colift::picture {
namespace {

struct DestroySurface {
  void operator()(cairo_surface_t* s) const { cairo_surface_destroy(s); }
};
struct DestroyContext {
  void operator()(cairo_t* c) const { cairo_destroy(c); }
};
using Surface = std::unique_ptr<cairo_surface_t, DestroySurface>;
using Context = std::unique_ptr<cairo_t, DestroyContext>;

constexpr int kMostPixels = 32767;  // cairo's own limit
constexpr const char* kFont = "DejaVu Sans";

void ink(cairo_t* c, const Colour& colour) {
  cairo_set_source_rgba(c, colour.r, colour.g, colour.b, colour.a);
}

void choose_font(cairo_t* c, const TextStyle& style) {
  cairo_select_font_face(c, kFont, CAIRO_FONT_SLANT_NORMAL,
                         style.bold ? CAIRO_FONT_WEIGHT_BOLD : CAIRO_FONT_WEIGHT_NORMAL);
  cairo_set_font_size(c, style.size);
}

// Strokes the current path and clears it.
void run_stroke(cairo_t* c, const Stroke& stroke) {
  cairo_set_line_cap(c, stroke.dashes.empty() ? CAIRO_LINE_CAP_ROUND : CAIRO_LINE_CAP_BUTT);
  cairo_set_line_join(c, CAIRO_LINE_JOIN_ROUND);
  cairo_set_dash(c, stroke.dashes.data(), static_cast<int>(stroke.dashes.size()), 0.0);
  if (stroke.halo.a > 0.0) {
    ink(c, stroke.halo);
    cairo_set_line_width(c, stroke.width + 2 * stroke.halo_width);
    cairo_stroke_preserve(c);
  }
  ink(c, stroke.colour);
  cairo_set_line_width(c, stroke.width);
  cairo_stroke(c);
}

void trace(cairo_t* c, const std::vector<Px>& points, bool closed) {
  cairo_new_path(c);
  for (const Px& p : points) cairo_line_to(c, p.x(), p.y());
  if (closed) cairo_close_path(c);
}

void trace(cairo_t* c, const Box& b, double radius) {
  constexpr double kQuarter = std::numbers::pi / 2;
  const double r = std::min({radius, b.width / 2, b.height / 2});
  cairo_new_path(c);
  cairo_arc(c, b.right() - r, b.y + r, r, -kQuarter, 0);
  cairo_arc(c, b.right() - r, b.bottom() - r, r, 0, kQuarter);
  cairo_arc(c, b.x + r, b.bottom() - r, r, kQuarter, 2 * kQuarter);
  cairo_arc(c, b.x + r, b.y + r, r, 2 * kQuarter, 3 * kQuarter);
  cairo_close_path(c);
}

// One line as cairo takes it: it stops drawing for good at a byte that is no UTF-8.
std::string one_line(const std::string& words) {
  std::string line = valid_utf8(words);
  std::replace(line.begin(), line.end(), '\n', ' ');
  return line;
}

}  // namespace

struct Canvas::State {
  Surface surface;
  Context context;
  int width, height;

  [[nodiscard]] cairo_t* c() const { return context.get(); }
};

Canvas::Canvas(int width, int height, const Colour& background) : state_(std::make_unique<State>()) {
  state_->width = std::clamp(width, 1, kMostPixels);
  state_->height = std::clamp(height, 1, kMostPixels);
  state_->surface.reset(cairo_image_surface_create(CAIRO_FORMAT_RGB24, state_->width, state_->height));
  state_->context.reset(cairo_create(state_->surface.get()));
  // grey antialiasing and no hinting: the same letters at every place, and no colour fringes in print
  cairo_font_options_t* options = cairo_font_options_create();
  cairo_font_options_set_antialias(options, CAIRO_ANTIALIAS_GRAY);
  cairo_font_options_set_hint_style(options, CAIRO_HINT_STYLE_NONE);
  cairo_font_options_set_hint_metrics(options, CAIRO_HINT_METRICS_OFF);
  cairo_set_font_options(state_->c(), options);
  cairo_font_options_destroy(options);
  ink(state_->c(), background);
  cairo_paint(state_->c());
}

Canvas::~Canvas() = default;
Canvas::Canvas(Canvas&&) noexcept = default;
Canvas& Canvas::operator=(Canvas&&) noexcept = default;

int Canvas::width() const {
  return state_->width;
}
int Canvas::height() const {
  return state_->height;
}

void Canvas::line(const Px& from, const Px& to, const Stroke& stroke) {
  polyline({from, to}, false, stroke);
}

void Canvas::polyline(const std::vector<Px>& points, bool closed, const Stroke& stroke) {
  if (points.empty()) return;
  trace(state_->c(), points, closed);
  run_stroke(state_->c(), stroke);
}

void Canvas::fill(const std::vector<Px>& polygon, const Colour& colour) {
  trace(state_->c(), polygon, true);
  ink(state_->c(), colour);
  cairo_fill(state_->c());
}

void Canvas::fill(const Box& box, const Colour& colour, double corner_radius) {
  trace(state_->c(), box, corner_radius);
  ink(state_->c(), colour);
  cairo_fill(state_->c());
}

void Canvas::outline(const Box& box, const Stroke& stroke, double corner_radius) {
  trace(state_->c(), box, corner_radius);
  run_stroke(state_->c(), stroke);
}

void Canvas::disc(const Px& center, double radius, const Colour& colour) {
  cairo_new_path(state_->c());
  cairo_arc(state_->c(), center.x(), center.y(), radius, 0, 2 * std::numbers::pi);
  ink(state_->c(), colour);
  cairo_fill(state_->c());
}

void Canvas::circle(const Px& center, double radius, const Stroke& stroke) {
  cairo_new_path(state_->c());
  cairo_arc(state_->c(), center.x(), center.y(), radius, 0, 2 * std::numbers::pi);
  run_stroke(state_->c(), stroke);
}

void Canvas::ellipse(const Px& center, const Eigen::Matrix2d& half_axes, const Colour& inside,
                     const Stroke& stroke) {
  constexpr int kCorners = 72;
  std::vector<Px> rim;
  for (int i = 0; i < kCorners; ++i) {
    const double angle = 2 * std::numbers::pi * i / kCorners;
    rim.push_back(center + half_axes * Px(std::cos(angle), std::sin(angle)));
  }
  if (inside.a > 0.0) fill(rim, inside);
  if (stroke.colour.a > 0.0) polyline(rim, true, stroke);
}

void Canvas::text(const Px& at, const std::string& words, const TextStyle& style) {
  const std::string safe = one_line(words);
  cairo_t* c = state_->c();
  choose_font(c, style);
  const double width = style.align == Align::Left ? 0.0 : text_width(safe, style);
  cairo_new_path(c);
  cairo_move_to(c, at.x() - (style.align == Align::Middle ? width / 2 : width), at.y());
  if (style.halo.a > 0.0) {
    cairo_text_path(c, safe.c_str());
    cairo_set_line_join(c, CAIRO_LINE_JOIN_ROUND);
    cairo_set_dash(c, nullptr, 0, 0.0);
    cairo_set_line_width(c, std::max(3.0, style.size * 0.28));
    ink(c, style.halo);
    cairo_stroke_preserve(c);
    ink(c, style.colour);
    cairo_fill(c);
  } else {
    ink(c, style.colour);
    cairo_show_text(c, safe.c_str());
    cairo_new_path(c);
  }
}

double Canvas::text_width(const std::string& words, const TextStyle& style) const {
  choose_font(state_->c(), style);
  cairo_text_extents_t extents;
  cairo_text_extents(state_->c(), one_line(words).c_str(), &extents);
  return extents.x_advance;
}

std::vector<std::string> Canvas::wrap(const std::string& words, double width, const TextStyle& style) const {
  std::vector<std::string> lines;
  std::string line;
  const auto fits = [&](const std::string& s) { return text_width(s, style) <= width; };
  const auto end_line = [&] {
    lines.push_back(line);
    line.clear();
  };
  const auto add_word = [&](std::string word) {
    if (word.empty()) return;
    const std::string joined = line.empty() ? word : line + ' ' + word;
    if (fits(joined)) {
      line = joined;
      return;
    }
    if (!line.empty()) end_line();
    while (!fits(word)) {
      // at least one character per line, whatever the width, so that this ends
      std::size_t cut = 1;
      while (cut < word.size() && continues_character(word[cut])) ++cut;
      for (std::size_t next = cut; next < word.size(); cut = next) {
        ++next;
        while (next < word.size() && continues_character(word[next])) ++next;
        if (!fits(word.substr(0, next))) break;
      }
      if (cut >= word.size()) break;
      lines.push_back(word.substr(0, cut));
      word.erase(0, cut);
    }
    line = word;
  };

  std::string word;
  for (const char ch : words) {
    if (ch != ' ' && ch != '\n' && ch != '\t') {
      word += ch;
      continue;
    }
    add_word(std::move(word));
    word.clear();
    if (ch == '\n') end_line();
  }
  add_word(std::move(word));
  if (!line.empty()) end_line();
  return lines;
}

void Canvas::image(int x, int y, int image_width, int image_height,
                   const std::vector<std::uint8_t>& rgb_bytes) {
  const Surface from(cairo_image_surface_create(CAIRO_FORMAT_RGB24, image_width, image_height));
  if (cairo_surface_status(from.get()) != CAIRO_STATUS_SUCCESS) return;
  cairo_surface_flush(from.get());
  unsigned char* rows = cairo_image_surface_get_data(from.get());
  const auto stride = static_cast<std::size_t>(cairo_image_surface_get_stride(from.get()));
  const auto w = static_cast<std::size_t>(image_width);
  for (std::size_t v = 0; v < static_cast<std::size_t>(image_height); ++v) {
    auto* row = reinterpret_cast<std::uint32_t*>(rows + v * stride);
    const std::uint8_t* source = rgb_bytes.data() + 3 * v * w;
    for (std::size_t u = 0; u < w; ++u, source += 3)
      row[u] = (std::uint32_t{source[0]} << 16) | (std::uint32_t{source[1]} << 8) | source[2];
  }
  cairo_surface_mark_dirty(from.get());
  cairo_set_source_surface(state_->c(), from.get(), x, y);
  cairo_rectangle(state_->c(), x, y, image_width, image_height);
  cairo_fill(state_->c());
}

Canvas::Clip::Clip(Canvas& canvas, const Box& box) : canvas_(canvas) {
  cairo_save(canvas_.state_->c());
  cairo_rectangle(canvas_.state_->c(), box.x, box.y, box.width, box.height);
  cairo_clip(canvas_.state_->c());
}

Canvas::Clip::~Clip() {
  cairo_restore(canvas_.state_->c());
}

Colour Canvas::at(int x, int y) const {
  cairo_surface_flush(state_->surface.get());
  const unsigned char* row =
      cairo_image_surface_get_data(state_->surface.get()) +
      static_cast<std::ptrdiff_t>(y) * cairo_image_surface_get_stride(state_->surface.get());
  return rgb(reinterpret_cast<const std::uint32_t*>(row)[x] & 0xFFFFFFu);
}

std::vector<std::uint8_t> Canvas::rgb_bytes() const {
  cairo_surface_flush(state_->surface.get());
  const unsigned char* const data = cairo_image_surface_get_data(state_->surface.get());
  const std::ptrdiff_t stride = cairo_image_surface_get_stride(state_->surface.get());
  std::vector<std::uint8_t> bytes;
  bytes.reserve(3 * static_cast<std::size_t>(width()) * static_cast<std::size_t>(height()));
  for (int y = 0; y < height(); ++y) {
    const auto* const row = reinterpret_cast<const std::uint32_t*>(data + y * stride);
    for (int x = 0; x < width(); ++x)
      for (const int shift : {16, 8, 0}) bytes.push_back(static_cast<std::uint8_t>(row[x] >> shift));
  }
  return bytes;
}

std::vector<std::uint8_t> Canvas::png() const {
  std::vector<std::uint8_t> bytes;
  const auto append = [](void* to, const unsigned char* data, unsigned length) {
    auto* out = static_cast<std::vector<std::uint8_t>*>(to);
    out->insert(out->end(), data, data + length);
    return CAIRO_STATUS_SUCCESS;
  };
  cairo_surface_write_to_png_stream(state_->surface.get(), append, &bytes);
  return bytes;
}

hal::Result<> Canvas::write_png(const std::filesystem::path& file) const {
  return write_file(file, png());
}

Eigen::Matrix2d ellipse_of(const Eigen::Matrix2d& covariance, double sigmas) {
  // closed form of the symmetric 2 x 2 eigenproblem
  const double a = covariance(0, 0), b = 0.5 * (covariance(0, 1) + covariance(1, 0)), d = covariance(1, 1);
  const double mean = 0.5 * (a + d), spread = std::hypot(0.5 * (a - d), b);
  const double angle = 0.5 * std::atan2(2 * b, a - d);
  const double major = std::sqrt(std::max(0.0, mean + spread)),
               minor = std::sqrt(std::max(0.0, mean - spread));
  Eigen::Matrix2d axes;
  axes << sigmas * major * std::cos(angle), -sigmas * minor * std::sin(angle),  //
      sigmas * major * std::sin(angle), sigmas * minor * std::cos(angle);
  return axes;
}

}  // namespace colift::picture
