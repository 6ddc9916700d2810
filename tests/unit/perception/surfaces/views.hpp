#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "../figures.hpp"
#include "perception/organised_cloud.hpp"
#include "perception/shape/shape_completion.hpp"
#include "perception/surfaces/find_surfaces.hpp"
#include "sim_hal/synthetic/scenes.hpp"

namespace colift::perception {

inline constexpr double kDegrees = M_PI / 180.0;

/// A scene as a Kinect sees it, in one frame or in the mean of several, with the object's pixels from the
/// truth.
struct SurfaceView {
  sim_hal::SyntheticScene scene;
  OrganisedCloud cloud;
  Target target;
  Ground ground;

  SurfaceView(sim_hal::ObjectKind kind, std::uint64_t seed, int frames = 1)
      : SurfaceView(sim_hal::make_scene(kind, seed), seed, frames) {}

  SurfaceView(const sim_hal::SyntheticScene& of, std::uint64_t seed, int frames = 1) : scene(of) {
    const sim_hal::Rendering truth = sim_hal::cast_rays(scene.world, scene.intrinsics, scene.X_WC);
    cloud = deproject(mean_frame(truth, seed, frames), scene.X_WC);
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      if (!cloud.seen(i) || truth.label[i] != sim_hal::Label::Target) continue;
      if (std::abs(cloud.depth_m[i] - truth.depth_m[i]) > 0.1f)
        continue;  // what shows the background at an edge
      target.pixels.push_back(static_cast<std::uint32_t>(i));
      target.points.emplace_back(cloud.x[i], cloud.y[i], cloud.z[i]);
      target.aabb.extend(target.points.back().cast<double>());
    }
    ground.plane = scene.ground;
  }

  [[nodiscard]] std::vector<Surface> surfaces() const {
    return find_surfaces(cloud, target, ground, NoiseModel{}, SurfaceConfig{});
  }
  [[nodiscard]] CompletedShape shape() const {
    return complete_shape(cloud, target, surfaces(), ground, NoiseModel{});
  }
  [[nodiscard]] Vec3 eye() const { return scene.X_WC.translation(); }

 private:
  static hal::DepthFrame mean_frame(const sim_hal::Rendering& truth, std::uint64_t seed, int frames) {
    hal::DepthFrame mean = sim_hal::measure(truth, {}, seed * 1000);
    if (frames == 1) return mean;
    std::vector<double> sum(mean.depth_m.size(), 0.0), count(sum);
    for (int f = 0; f < frames; ++f) {
      const hal::DepthFrame one = sim_hal::measure(truth, {}, seed * 1000 + static_cast<std::uint64_t>(f));
      for (std::size_t i = 0; i < sum.size(); ++i)
        if (one.depth_m[i] == one.depth_m[i]) sum[i] += static_cast<double>(one.depth_m[i]), count[i] += 1;
    }
    for (std::size_t i = 0; i < sum.size(); ++i)
      mean.depth_m[i] = 2 * count[i] > frames ? static_cast<float>(sum[i] / count[i]) : NAN;
    return mean;
  }
};

inline std::vector<Rectangle> rectangles_of(const std::vector<Surface>& surfaces) {
  std::vector<Rectangle> r;
  for (const Surface& s : surfaces)
    if (const auto* x = std::get_if<Rectangle>(&s)) r.push_back(*x);
  return r;
}
inline std::vector<Cylinder> cylinders_of(const std::vector<Surface>& surfaces) {
  std::vector<Cylinder> c;
  for (const Surface& s : surfaces)
    if (const auto* x = std::get_if<Cylinder>(&s)) c.push_back(*x);
  return c;
}

/// A scene with one object and a floor, seen from 1.6 m away.
inline sim_hal::SyntheticScene scene_of(const std::vector<sim_hal::Shape>& object,
                                        const Vec3& eye = {1.3, 0.5, 1.1}, const Vec3& at = {0, 0, 0.2}) {
  sim_hal::SyntheticScene s;
  s.world.shapes.push_back(sim_hal::half_space(Vec3::Zero(), Vec3::UnitZ(), sim_hal::Label::Ground));
  for (const auto& shape : object) s.world.shapes.push_back(shape);
  s.X_WC = sim_hal::look_at(eye, at);
  return s;
}

}  // namespace colift::perception
