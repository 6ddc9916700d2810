#pragma once

#include <cstdint>
#include <string>

#include "control/session/scene_analysis.hpp"
#include "sim_hal/synthetic/rooms.hpp"

namespace colift::experiments {

/// What became of the target that was found, against the truth of every pixel.
enum class RoomVerdict {
  Right,    ///< At least 85 % of its points are the object's, and 60 % of the object's seen pixels are in it.
  Partly,   ///< Most of its points are the object's.
  Nothing,  ///< No target; right where there is no object.
  Wrong,    ///< Most of its points are something else's.
  Person,   ///< Most of its points are a person's.
};

[[nodiscard]] std::string word(RoomVerdict verdict);

/// A random room, seen once by a method that knows neither gravity nor the camera's pose.
struct SeenRoom {
  sim_hal::RandomRoom room;
  sim_hal::Rendering truth;
  sim_hal::ObjectInView object;
  control::SceneAnalysis analysis;
  RoomVerdict verdict = RoomVerdict::Nothing;
  std::size_t person_pixels = 0;
  bool ground_right = false;  ///< Within 3 degrees and 10 cm.

  /// A person would point at the object: at least 1500 of its pixels, not cut, less than 30 % of it hidden.
  [[nodiscard]] bool solvable() const;
  /// "solvable", "hard", or "empty" where there is no object.
  [[nodiscard]] std::string object_class() const;
};

/// Seed: of the sensor's noise.
[[nodiscard]] SeenRoom see_room(sim_hal::RandomRoom room, std::uint64_t seed, control::Method method);

}  // namespace colift::experiments
