#include "control/session/picture_check.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace colift::control {
namespace {

constexpr std::size_t kEvery = 5;  // points of the target that its rectangle is made from

}  // namespace

std::optional<std::string> image_fault(const perception::OrganisedCloud& cloud,
                                       const perception::Target& target, const ImageCheckConfig& config) {
  int u0 = cloud.width(), u1 = -1, v0 = cloud.height(), v1 = -1;
  for (std::size_t i = 0; i < target.points.size(); i += kEvery) {
    const auto at = cloud.project(target.points[i].cast<double>());
    if (!(at.depth_m > 0.0) || !cloud.contains(at.u, at.v)) continue;
    const int u = static_cast<int>(std::lround(at.u)), v = static_cast<int>(std::lround(at.v));
    u0 = std::min(u0, u), u1 = std::max(u1, u);
    v0 = std::min(v0, v), v1 = std::max(v1, v);
  }
  if (u1 < u0) return std::nullopt;
  u0 = std::max(0, u0 - config.margin_px), u1 = std::min(cloud.width() - 1, u1 + config.margin_px);
  v0 = std::max(0, v0 - config.margin_px), v1 = std::min(cloud.height() - 1, v1 + config.margin_px);
  long all = 0, holes = 0;
  for (int v = v0; v <= v1; ++v)
    for (int u = u0; u <= u1; ++u, ++all)
      holes += !cloud.seen(static_cast<std::size_t>(v) * static_cast<std::size_t>(cloud.width()) +
                           static_cast<std::size_t>(u));
  const double part = static_cast<double>(holes) / static_cast<double>(all);
  if (part <= config.max_hole_fraction) return std::nullopt;
  return fmt::format(
      "{:.0f} % of the pixels on and about the object see nothing (at most {:.0f}): sunlight, dark or shiny "
      "things?",
      1e2 * part, 1e2 * config.max_hole_fraction);
}

}  // namespace colift::control
