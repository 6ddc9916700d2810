#pragma once

#include <cstdint>

#include "sim_hal/scenario/scenario.hpp"
#include "sim_hal/synthetic/hash_random.hpp"

namespace colift::sim_hal {

enum class RandomKind { Table, Box };

/// A scenario drawn from a seed, for figures over many lifts: a table or a long box of random size, mass,
/// friction and pose whose near side the robot reaches, a partner who takes the far side, and a camera that
/// sees both from the side. Same seed, same scenario.
[[nodiscard]] Scenario random_scenario(RandomKind kind, std::uint64_t seed);

/// Puts the camera beside the object, so that neither the arm nor the person hides it, with all of it and
/// room for a hand at the partner's grasp in view: between `least_m` and `most_m` beyond its middle. For
/// objects whose size is three lengths.
void draw_camera(Scenario& scenario, Draws& draws, double least_m = 0.4, double most_m = 1.1);

}  // namespace colift::sim_hal
