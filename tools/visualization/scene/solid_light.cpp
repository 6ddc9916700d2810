#include "tools/visualization/scene/solid_light.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "sim_hal/synthetic/ray_caster.hpp"
#include "sim_hal/synthetic/scene_objects.hpp"

namespace colift::picture {
namespace {

constexpr double kKeySpread = 0.11;      // half angle of the window (rad): soft shadows
constexpr double kFar_m = 400.0;         // from there rays are parallel
constexpr float kOff_px = 1.5f;          // a surface does not shade itself
constexpr float kGroundShade_m = 0.25f;  // beneath it, what looks down is darkened by the ground

// Points of a unit disc or half sphere, evenly: a sunflower's seeds.
Eigen::Vector2d seed(int k, int of) {
  constexpr double kGoldenAngle = 2.399963229728653;
  const double r = std::sqrt((k + 0.5) / of), angle = kGoldenAngle * k;
  return {r * std::cos(angle), r * std::sin(angle)};
}

}  // namespace

SolidLights::SolidLights(const sim_hal::World& world, const Vec3f& key, bool coarse)
    : key_size_(coarse ? Size{10, 384} : Size{24, 768}), sky_size_(coarse ? Size{32, 128} : Size{96, 256}) {
  sim_hal::World solid;
  hal::Aabb bounds;
  for (const sim_hal::Shape& shape : world.shapes) {
    if (shape.kind == sim_hal::Shape::Kind::HalfSpace) continue;
    solid.shapes.push_back(shape);
    for (const hal::Vec3& p : sim_hal::corners(shape)) bounds.extend(p);
  }
  if (solid.shapes.empty()) return;
  middle_ = bounds.center().cast<float>();
  radius_ = static_cast<float>(0.5 * bounds.diagonal().norm());

  const auto [u, v] = hal::tangents(key.cast<double>());
  for (int i = 0; i < key_size_.maps; ++i) {
    const Eigen::Vector2d d = kKeySpread * seed(i, key_size_.maps);
    add(solid, key_, (key.cast<double>() + d.x() * u + d.y() * v).normalized().cast<float>(), key_size_.side,
        i);
  }
  for (int i = 0; i < sky_size_.maps; ++i) {
    // the same share of the sphere for each, horizon to zenith
    const Eigen::Vector2d d = seed(i, sky_size_.maps);
    const double z = 1.0 - d.squaredNorm(), flat = std::sqrt(1.0 - z * z);
    const Eigen::Vector2d side = flat * d.normalized();
    add(solid, sky_, Eigen::Vector3d(side.x(), side.y(), z).cast<float>(), sky_size_.side, i);
  }
}

void SolidLights::add(const sim_hal::World& world, std::vector<Map>& maps, const Vec3f& towards, int side,
                      double turn) {
  // each map is turned against the one before, so that their pixels do not add up to steps
  const Eigen::Vector3d axis = towards.cast<double>();
  const Eigen::AngleAxisd turned(turn, axis);
  const auto [right, other] = hal::tangents(axis);
  hal::Pose X_WC = hal::Pose::Identity();
  const Eigen::Vector3d x = turned * right;
  X_WC.linear() << x, (-axis).cross(x), -axis;
  X_WC.translation() = middle_.cast<double>() + kFar_m * axis;
  const double focal = 0.5 * side * kFar_m / static_cast<double>(radius_), centre = 0.5 * side - 0.5;
  const sim_hal::Rendering seen = sim_hal::cast_rays(world, {side, side, focal, focal, centre, centre}, X_WC);
  Map map;
  map.towards = towards;
  const float texels_m = 0.5f * static_cast<float>(side) / radius_;
  map.right = texels_m * X_WC.linear().col(0).cast<float>();
  map.down = texels_m * X_WC.linear().col(1).cast<float>();
  map.height_m.reserve(seen.depth_m.size());
  for (const float z : seen.depth_m)
    map.height_m.push_back(std::isnan(z) ? -std::numeric_limits<float>::infinity()
                                         : static_cast<float>(kFar_m) - z);
  maps.push_back(std::move(map));
}

std::vector<SolidLights::Sum> SolidLights::cast(const std::vector<Map>& maps, int side,
                                                std::span<const SurfacePoint> points) const {
  std::vector<Sum> sums(points.size());
  const float texel = 2.0f * radius_ / static_cast<float>(side), middle = 0.5f * static_cast<float>(side);
  const auto limit = static_cast<float>(side);
  for (const Map& map : maps)
    for (std::size_t i = 0; i < points.size(); ++i) {
      const float facing = map.towards.dot(points[i].normal);
      if (facing <= 0.0f) continue;
      sums[i].all += facing;
      const Vec3f from = points[i].p + kOff_px * texel * points[i].normal - middle_;
      const float u = middle + map.right.dot(from), v = middle + map.down.dot(from);
      if (u >= 0.0f && v >= 0.0f && u < limit && v < limit) {
        const auto at =
            static_cast<std::size_t>(v) * static_cast<std::size_t>(side) + static_cast<std::size_t>(u);
        if (map.towards.dot(from) + 0.5f * texel < map.height_m[at]) continue;
      }
      sums[i].lit += facing;
      ++sums[i].count;
    }
  return sums;
}

std::vector<SolidLight> SolidLights::at(std::span<const SurfacePoint> points) const {
  const std::vector<Sum> key = cast(key_, key_size_.side, points), sky = cast(sky_, sky_size_.side, points);
  std::vector<SolidLight> lights(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!key_.empty()) lights[i].key = static_cast<float>(key[i].count) / static_cast<float>(key_.size());
    // what faces the ground gets its light from there, less where it is close
    const float up = 0.5f * (1.0f + points[i].normal.z());
    const float from_ground = std::clamp(points[i].p.z() / kGroundShade_m, 0.0f, 1.0f);
    lights[i].sky = up * (sky[i].all > 0.0f ? sky[i].lit / sky[i].all : 1.0f) + (1.0f - up) * from_ground;
  }
  return lights;
}

}  // namespace colift::picture
