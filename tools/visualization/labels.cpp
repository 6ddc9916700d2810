#include "tools/visualization/labels.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace colift::picture {

bool Labels::free(const Box& box) const {
  if (box.x < area_.x || box.y < area_.y || box.right() > area_.right() || box.bottom() > area_.bottom())
    return false;
  return std::none_of(taken_.begin(), taken_.end(), [&](const Box& t) { return t.overlaps(box); });
}

bool Labels::place(const Px& anchor, const std::string& words, const TextStyle& style, double clearance,
                   bool must) {
  const double width = canvas_.text_width(words, style), height = style.size;
  // right, left, above, below, then the corners
  constexpr std::array<std::array<double, 2>, 8> kSides{
      {{1, 0}, {-1, 0}, {0, -1}, {0, 1}, {0.7, -0.7}, {-0.7, -0.7}, {0.7, 0.7}, {-0.7, 0.7}}};
  const std::array<double, 5> reach{clearance, clearance + 14, clearance + 34, clearance + 64,
                                    clearance + 110};
  const std::size_t tries = must ? reach.size() : 3;
  for (std::size_t r = 0; r < tries; ++r)
    for (const auto& [sx, sy] : kSides) {
      const Px middle = anchor + Px(sx * (reach[r] + width / 2), sy * (reach[r] + height / 2));
      const Box box = Box{middle.x() - width / 2, middle.y() - height / 2, width, height}.grown(2);
      if (!free(box)) continue;
      if (r > 1) {
        const Px near(std::clamp(anchor.x(), box.x, box.right()),
                      std::clamp(anchor.y(), box.y, box.bottom()));
        canvas_.line(
            near, anchor,
            {.colour = style.colour.with_alpha(0.8), .width = 1.2, .halo = style.halo, .halo_width = 1});
      }
      TextStyle middle_style = style;
      middle_style.align = Align::Middle;
      canvas_.text({middle.x(), middle.y() + 0.36 * style.size}, words, middle_style);
      keep_clear(box);
      return true;
    }
  return false;
}

std::string centimetres(double length_m) {
  const double cm = 100.0 * length_m;
  return std::abs(cm) < 9.95 ? fmt::format("{:.1f}", cm) : fmt::format("{:.0f}", cm);
}

std::string length_text(double length_m) {
  if (!std::isfinite(length_m)) return "unknown";
  return std::abs(length_m) < 0.995 ? centimetres(length_m) + " cm" : fmt::format("{:.2f} m", length_m);
}

std::string count_text(std::size_t count) {
  std::string digits = std::to_string(count);
  for (auto at = static_cast<std::ptrdiff_t>(digits.size()) - 3; at > 0; at -= 3)
    digits.insert(static_cast<std::size_t>(at), "\u2009");
  return digits;
}

}  // namespace colift::picture
