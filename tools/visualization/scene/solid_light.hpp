#pragma once

#include <span>
#include <vector>

#include "sim_hal/synthetic/shapes.hpp"

namespace colift::picture {

using Vec3f = Eigen::Vector3f;

/// Light that reaches a point, 0 (none) to 1.
struct SolidLight {
  float key = 1.0f;  ///< From one bright window.
  float sky = 1.0f;  ///< From all around, above the horizon.
};

struct SurfacePoint {
  Vec3f p = Vec3f::Zero(), normal = Vec3f::Zero();  ///< Outward unit normal (W).
};

/// Shadows of a world: depth images of it from many directions of the light (shadow maps; Williams 1978),
/// cast by the simulator's ray caster. A point is lit from a direction when that image shows nothing before
/// it.
class SolidLights {
 public:
  /// `key`: towards the window, unit. Half spaces throw no shadow. `coarse`: fewer and smaller maps.
  SolidLights(const sim_hal::World& world, const Vec3f& key, bool coarse);

  /// For points of surfaces, best neighbours of an image row: they meet in the maps too.
  [[nodiscard]] std::vector<SolidLight> at(std::span<const SurfacePoint> points) const;

 private:
  struct Map {
    Vec3f towards;                // the light, unit
    Vec3f right, down;            // of the map, in its pixels per metre
    std::vector<float> height_m;  // of what is nearest to the light, along `towards` from the middle
  };
  struct Size {
    int maps, side;  // directions of the light; pixels of each one's map
  };
  void add(const sim_hal::World& world, std::vector<Map>& maps, const Vec3f& towards, int side, double turn);
  struct Sum {
    float all = 0.0f, lit = 0.0f;  // over the directions before the surface, each by how it faces it
    int count = 0;                 // of those that light it
  };
  [[nodiscard]] std::vector<Sum> cast(const std::vector<Map>& maps, int side,
                                      std::span<const SurfacePoint> points) const;

  Vec3f middle_ = Vec3f::Zero();  // of a ball that holds everything that throws a shadow
  float radius_ = 0.0f;
  Size key_size_, sky_size_;
  std::vector<Map> key_, sky_;
};

}  // namespace colift::picture
