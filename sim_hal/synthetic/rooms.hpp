#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "sim_hal/synthetic/depth_sensors.hpp"
#include "sim_hal/synthetic/scenes.hpp"
#include "sim_hal/synthetic/shapes.hpp"
#include "sim_hal/synthetic/stances.hpp"

namespace colift::sim_hal {

/// What a room of random furniture shows, beside the object that is to be carried.
struct RandomRoom {
  std::string name;  ///< What is in it, in words.
  World world;  ///< Label::Target: the object; Partner: persons; Wall: walls, doors; Clutter: all others.
  DepthSensor sensor = DepthSensor::Kinect;
  hal::CameraIntrinsics intrinsics;
  Pose X_WC = Pose::Identity();
  bool has_object = false, has_person = false;
  std::optional<Stance> stance;  ///< Of the person of make_occupied_room(), where there was room for one.
};

/// A room drawn from a seed, as laboratories, offices and kitchens are and as no scene of make_scene() is:
/// walls with doors and windows, cupboards, a sofa, stairs or a bench along them, small things on the floor,
/// standing, sitting and crouching persons, in four of five rooms an object near or away from all that. One
/// of four sensors, held at any height from 0.25 to 1.9 m and rolled by up to 12 degrees, sees the floor and
/// whatever stands in its way.
[[nodiscard]] RandomRoom make_room(std::uint64_t seed);

/// A room of make_room() with a person in a drawn Stance, clear of the object by 25 cm or more (in one of
/// four as close as 5 cm); every other camera looks at him.
[[nodiscard]] RandomRoom make_occupied_room(std::uint64_t seed);

/// What can be seen of the object in a rendering of the room.
struct ObjectInView {
  std::size_t pixels = 0;        ///< With the object's label.
  double hidden_fraction = 0.0;  ///< Of the pixels that it would have alone in the room.
  bool cut = false;              ///< Touches the rim of the image.
};
[[nodiscard]] ObjectInView object_in_view(const RandomRoom& room, const Rendering& truth);

}  // namespace colift::sim_hal
