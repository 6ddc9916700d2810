#include "perception/ground_and_target/slivers.hpp"

#include <algorithm>

#include "perception/ground_and_target/components.hpp"

namespace colift::perception {
namespace {

constexpr double kBeside_m = 0.01, kBesideSigmas = 3.0;  // the box leaves out strays
constexpr double kRaised_m = 0.015;                      // over the ground, at least
constexpr double kRaisedSigmas = 4.0;                    // ... and over its noise
constexpr double kLargest_m2 = 0.005;  // visible area: as the smallest object that is carried
constexpr double kInBox = 0.9;         // of its pixels; some fly off towards the background
constexpr double kJumpSigmas = 3.0;    // depth difference within one region
constexpr float kJump_m = 0.012f;

/// Part of the image in which the target lies, and a little around it. What goes on beyond it is no sliver.
constexpr int kAround_px = 12;
struct Window {
  int u0, v0, u1, v1;
};

Window window_of(const Target& target, int width, int height) {
  const auto w = static_cast<std::uint32_t>(width);
  Window at{width, height, 0, 0};
  for (const std::uint32_t i : target.pixels) {
    const int u = static_cast<int>(i % w), v = static_cast<int>(i / w);
    at = {std::min(at.u0, u), std::min(at.v0, v), std::max(at.u1, u + 1), std::max(at.v1, v + 1)};
  }
  return {std::max(0, at.u0 - kAround_px), std::max(0, at.v0 - kAround_px),
          std::min(width, at.u1 + kAround_px), std::min(height, at.v1 + kAround_px)};
}

}  // namespace

std::vector<std::uint32_t> find_slivers(const OrganisedCloud& cloud, const Target& target,
                                        const Ground& ground, const NoiseModel& noise) {
  std::vector<std::uint32_t> slivers;
  if (target.pixels.empty()) return slivers;
  const int width = cloud.width(), height = cloud.height();
  const Window window = window_of(target, width, height);
  std::vector<std::uint8_t> mask(cloud.size(), 0);
  for (int v = window.v0; v < window.v1; ++v) {
    for (int u = window.u0; u < window.u1; ++u) {
      const auto i = static_cast<std::size_t>(v * width + u);
      if (!cloud.seen(i)) continue;
      const double least =
          std::max(kRaised_m, kRaisedSigmas * noise.sigma(static_cast<double>(cloud.depth_m[i])));
      mask[i] = ground.plane.height(cloud.point(i)) > least;
    }
  }
  for (const std::uint32_t i : target.pixels) mask[i] = 0;
  const DepthJump jump{kJump_m + static_cast<float>(kJumpSigmas * noise.sigma0_m),
                       static_cast<float>(kJumpSigmas * noise.sigma2_per_m + 1.5 * noise.step2_per_m)};
  const Components regions = connected_components(cloud.depth_m, mask, width, height, jump);

  const Eigen::Matrix3d axes = target.obb.axes.transpose();
  const Eigen::Array3d half = 0.5 * target.obb.size.array() + kBeside_m;
  const auto in_box = [&](std::size_t i) {
    const double stray = kBesideSigmas * noise.sigma(static_cast<double>(cloud.depth_m[i]));
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
    if (!r.goes_on && r.area_m2 < kLargest_m2 && r.inside >= kInBox * regions.pixels[label] && in_box(i))
      slivers.push_back(static_cast<std::uint32_t>(i));
  });
  return slivers;
}

}  // namespace colift::perception
