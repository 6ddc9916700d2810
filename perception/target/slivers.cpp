#include "perception/target/slivers.hpp"

#include <algorithm>

#include "perception/target/regions/components.hpp"

namespace colift::perception {
namespace {

/// Part of the image in which the target lies, and a little around it. What continues beyond it is no sliver.
struct Window {
  int u0, v0, u1, v1;
};

Window window_of(const Target& target, int width, int height, int margin_px) {
  const auto w = static_cast<std::uint32_t>(width);
  Window at{width, height, 0, 0};
  for (const std::uint32_t i : target.pixels) {
    const int u = static_cast<int>(i % w), v = static_cast<int>(i / w);
    at = {std::min(at.u0, u), std::min(at.v0, v), std::max(at.u1, u + 1), std::max(at.v1, v + 1)};
  }
  return {std::max(0, at.u0 - margin_px), std::max(0, at.v0 - margin_px), std::min(width, at.u1 + margin_px),
          std::min(height, at.v1 + margin_px)};
}

}  // namespace

std::vector<std::uint32_t> find_slivers(const OrganisedCloud& cloud, const Target& target,
                                        const Ground& ground, const NoiseModel& noise,
                                        const SliverConfig& config) {
  std::vector<std::uint32_t> slivers;
  if (target.pixels.empty()) return slivers;
  const int width = cloud.width(), height = cloud.height();
  const Window window = window_of(target, width, height, config.window_margin_px);
  std::vector<std::uint8_t> mask(cloud.size(), 0);
  for (int v = window.v0; v < window.v1; ++v) {
    for (int u = window.u0; u < window.u1; ++u) {
      const auto i = static_cast<std::size_t>(v * width + u);
      if (!cloud.seen(i)) continue;
      const double least = std::max(
          config.min_height_m, config.min_height_sigma * noise.sigma(static_cast<double>(cloud.depth_m[i])));
      mask[i] = ground.plane.height(cloud.point(i)) > least;
    }
  }
  for (const std::uint32_t i : target.pixels) mask[i] = 0;
  const DepthJump jump{
      static_cast<float>(config.jump_base_m) + static_cast<float>(config.jump_sigma * noise.sigma0_m),
      static_cast<float>(config.jump_sigma * noise.sigma2_per_m + config.jump_steps * noise.step2_per_m)};
  const Components regions = connected_components(cloud.depth_m, mask, width, height, jump);

  const Eigen::Matrix3d axes = target.obb.axes.transpose();
  const Eigen::Array3d half = 0.5 * target.obb.size.array() + config.box_margin_m;
  const auto in_box = [&](std::size_t i) {
    const double stray = config.box_margin_sigma * noise.sigma(static_cast<double>(cloud.depth_m[i]));
    return ((axes * (cloud.point(i) - target.obb.center)).array().abs() <= half + stray).all();
  };
  struct Region {
    double area_m2 = 0.0, inside = 0.0;
    bool goes_on = false;
  };
  std::vector<Region> found(regions.pixels.size());
  const double pixel_area = 1.0 / (cloud.intrinsics.fx * cloud.intrinsics.fy);
  const auto each_pixel = [&](auto&& visit) {
    for (const Components::Run& run : regions.runs)
      for (int u = run.first; u <= run.last; ++u)
        visit(static_cast<std::size_t>(run.label), static_cast<std::size_t>(run.row * width + u));
  };
  each_pixel([&](std::size_t label, std::size_t i) {
    const auto depth = static_cast<double>(cloud.depth_m[i]);
    found[label].area_m2 += depth * depth * pixel_area;
    found[label].inside += in_box(i);
    const int u = static_cast<int>(i) % width, v = static_cast<int>(i) / width;
    if (u == window.u0 || u + 1 == window.u1 || v == window.v0 || v + 1 == window.v1)
      found[label].goes_on = true;
  });
  each_pixel([&](std::size_t label, std::size_t i) {
    const Region& r = found[label];
    if (!r.goes_on && r.area_m2 < config.max_area_m2 &&
        r.inside >= config.min_in_box_fraction * regions.pixels[label] && in_box(i))
      slivers.push_back(static_cast<std::uint32_t>(i));
  });
  return slivers;
}

}  // namespace colift::perception
