#pragma once

#include <vector>

#include "sim_hal/synthetic/shapes.hpp"

namespace colift::picture {

using Vec3f = Eigen::Vector3f;

/// Light that reaches a point, 0 (none) to 1.
struct SolidLight {
  float key = 1.0f;  ///< From one bright window.
  float sky = 1.0f;  ///< From all around, above the horizon.
};

/// Shadows of a world: depth images of it from many directions of the light (shadow maps; Williams 1978),
/// cast by the simulator's ray caster. A point is lit from a direction when that image shows nothing before
/// it.
class SolidLights {
 public:
  /// `key`: towards the window, unit. Half spaces throw no shadow.
  SolidLights(const sim_hal::World& world, const Vec3f& key);

  /// For a point of a surface and its outward unit normal (W).
  [[nodiscard]] SolidLight at(const Vec3f& p, const Vec3f& normal) const;

 private:
  struct Map {
    Vec3f towards;  // the light, unit
    Vec3f right, down;
    std::vector<float> height_m;  // of what is nearest to the light, along `towards` from the middle
  };
  void add(const sim_hal::World& world, std::vector<Map>& maps, const Vec3f& towards, int side, double turn);
  [[nodiscard]] bool lit(const Map& map, int side, const Vec3f& p, const Vec3f& normal) const;

  Vec3f middle_ = Vec3f::Zero();  // of a ball that holds everything that throws a shadow
  float radius_ = 0.0f;
  std::vector<Map> key_, sky_;
};

}  // namespace colift::picture
