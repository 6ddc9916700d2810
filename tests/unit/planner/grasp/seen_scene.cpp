#include "seen_scene.hpp"

#include <cmath>
#include <limits>

namespace colift::tests {
namespace {

using hal::Vec3;

/// The part of a face on which the camera has points, if that is more than a few pixels.
std::optional<perception::Rectangle> seen_part(const sim_hal::TrueFace& face, const SeenScene& seen,
                                               const std::vector<std::uint32_t>& target,
                                               const perception::OrganisedCloud& exact) {
  if (face.normal.dot(seen.cloud.X_WC.translation() - face.center) <= 0.0) return std::nullopt;
  Eigen::Vector2d low = Eigen::Vector2d::Constant(1e9), high = -low;
  int count = 0;
  for (const std::uint32_t pixel : target) {
    const Vec3 d = exact.point(pixel) - face.center;
    const Eigen::Vector2d p(d.dot(face.u), d.dot(face.v));
    if (std::abs(d.dot(face.normal)) > 0.001) continue;
    if (std::abs(p.x()) > 0.5 * face.width + 0.001 || std::abs(p.y()) > 0.5 * face.height + 0.001) continue;
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
    ++count;
  }
  if (count < 60) return std::nullopt;
  perception::Rectangle r;
  const Eigen::Vector2d middle = 0.5 * (low + high);
  r.center = face.center + middle.x() * face.u + middle.y() * face.v;
  r.normal = face.normal;
  r.u = face.u;
  r.v = face.v;
  r.size = high - low;
  r.fill = 1.0;
  return r;
}

}  // namespace

SeenScene see(const sim_hal::SyntheticScene& truth, bool noise, std::uint64_t seed) {
  SeenScene seen;
  seen.truth = truth;
  const sim_hal::Rendering image = sim_hal::cast_rays(truth.world, truth.intrinsics, truth.X_WC);
  const auto exact = perception::deproject(sim_hal::measure_ideal(image), truth.X_WC);
  seen.cloud = noise
                   ? perception::deproject(sim_hal::measure(image, sim_hal::KinectNoise{}, seed), truth.X_WC)
                   : exact;

  seen.scene.ground = perception::Ground{truth.ground, 1000, 0.0};
  perception::Target target;
  std::vector<std::uint32_t> pixels;
  for (std::uint32_t pixel = 0; pixel < exact.size(); ++pixel) {
    if (image.label[pixel] != sim_hal::Label::Target || !exact.seen(pixel)) continue;
    pixels.push_back(pixel);
    // a flying pixel belongs to nobody: perception takes those out of its targets
    if (!seen.cloud.seen(pixel) || std::abs(seen.cloud.depth_m[pixel] - exact.depth_m[pixel]) > 0.03)
      continue;
    target.pixels.push_back(pixel);
    const Eigen::Vector3f p(seen.cloud.x[pixel], seen.cloud.y[pixel], seen.cloud.z[pixel]);
    target.points.push_back(p);
    target.aabb.extend(p.cast<double>());
  }
  target.cog = truth.cog;
  for (const auto& face : truth.faces) {
    if (const auto r = seen_part(face, seen, pixels, exact)) seen.scene.surfaces.emplace_back(*r);
  }
  for (const auto& c : truth.cylinders) {
    seen.scene.surfaces.emplace_back(perception::Cylinder{c.center, c.axis, c.radius, c.length});
  }
  seen.scene.target = std::move(target);
  return seen;
}

sim_hal::SyntheticScene scene_of(const std::vector<sim_hal::Shape>& shapes, const Vec3& eye,
                                 const Vec3& look_at) {
  sim_hal::SyntheticScene scene;
  scene.world.shapes = shapes;
  scene.world.shapes.push_back(sim_hal::half_space(Vec3::Zero(), Vec3::UnitZ(), sim_hal::Label::Ground));
  scene.X_WC = sim_hal::look_at(eye, look_at);
  Vec3 sum = Vec3::Zero();
  int count = 0;
  for (const auto& shape : shapes) {
    if (shape.label != sim_hal::Label::Target) continue;
    sum += shape.X_WS.translation();
    ++count;
  }
  scene.cog = sum / std::max(1, count);
  return scene;
}

void add_faces(sim_hal::SyntheticScene& scene, const Vec3& center, const Vec3& size) {
  for (int axis = 0; axis < 3; ++axis) {
    for (const double side : {1.0, -1.0}) {
      const int a = (axis + 1) % 3, b = (axis + 2) % 3;
      sim_hal::TrueFace f;
      f.normal = side * Vec3::Unit(axis);
      f.center = center + 0.5 * size[axis] * f.normal;
      f.u = Vec3::Unit(a);
      f.v = f.normal.cross(f.u);
      f.width = size[a];
      f.height = size[b];
      scene.faces.push_back(f);
    }
  }
}

}  // namespace colift::tests
