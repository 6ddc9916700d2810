#include "tools/experiments/trials/layouts.hpp"

#include <fmt/format.h>

#include <cmath>

#include "hal/types/units.hpp"
#include "sim_hal/scenario/random_scenario.hpp"
#include "sim_hal/synthetic/hash_random.hpp"

namespace colift::experiments {
namespace {

using sim_hal::Draws;
using sim_hal::Scenario;

constexpr double kArrives_s = 1.7;  // seen from one second before: not yet while the scene is learnt

Scenario soon(Scenario s) {
  s.partner.arrives_s = kArrives_s;
  return s;
}

Scenario random(sim_hal::RandomKind kind, int index, std::uint64_t seed) {
  return soon(sim_hal::random_scenario(kind, sim_hal::hash(seed, 7000, static_cast<std::uint64_t>(index))));
}

}  // namespace

Scenario table_layout(int index, std::uint64_t seed) {
  if (index == 0) return soon(sim_hal::built_in_scenario());
  if (index > 1) return random(sim_hal::RandomKind::Table, index, seed);
  Scenario s = sim_hal::built_in_scenario();
  s.name = "table, pose 2";
  s.object.size = {0.9, 0.6, 0.5};
  s.object.mass = 5.0;
  s.object.xyz = {1.15, -0.05, 0.0};
  s.object.yaw_deg = -25.0;
  s.camera.xyz = {1.9, 1.5, 1.5};
  s.camera.look_at = {1.1, 0.0, 0.3};
  s.partner.grasp = {0.45, -0.12, 0.4875};
  return soon(s);
}

Scenario box_layout(int index, std::uint64_t seed) {
  return random(sim_hal::RandomKind::Box, index, seed);
}

Scenario shipped_box() {
  Scenario s;
  s.name = "box";
  s.object.kind = "box";
  s.object.size = {0.9, 0.16, 0.25};
  s.object.mass = 3.5;
  s.object.xyz = {1.12, 0.0, 0.0};
  s.object.yaw_deg = 8.0;
  s.camera.xyz = {2.1, -1.4, 1.5};
  s.camera.look_at = {1.15, 0.0, 0.3};
  s.partner.grasp = {0.45, 0.0, 0.2};
  return soon(s);
}

Scenario pipe_layout(int index, std::uint64_t seed) {
  Draws draws(sim_hal::hash(seed, 7300, static_cast<std::uint64_t>(index)), 7300);
  Scenario s;
  s.name = fmt::format("pipe {}", index);
  s.object.kind = "cylinder";
  const bool shipped = index == 0;
  const double radius = shipped ? 0.04 : draws.between(0.025, 0.045);
  const double length = shipped ? 1.2 : draws.between(1.0, 1.4);
  const double height = shipped ? 0.25 : draws.between(0.22, 0.32);
  const double yaw = shipped ? 10.0 : draws.between(-15.0, 15.0);
  s.object.size = {radius, length};
  s.object.mass = shipped ? 3.0 : draws.between(1.5, 4.0);
  s.object.friction = shipped ? 0.7 : draws.between(0.6, 0.9);
  const double bearing = shipped ? 0.0 : draws.between(-0.12, 0.12);
  const double away = 0.5 * length + (shipped ? 0.5 : draws.between(0.45, 0.55));
  s.object.xyz = {away * std::cos(bearing), away * std::sin(bearing), height};
  s.object.yaw_deg = yaw;
  const double c = std::cos(hal::deg_to_rad(yaw)), d = std::sin(hal::deg_to_rad(yaw));
  for (const double along : {-0.25 * length, 0.25 * length}) {
    sim_hal::ScenarioClutter block;
    block.shape = "box";
    // slim ones: what touches the pipe is one object with it to a camera
    block.size = shipped ? std::vector<double>{0.10, 0.22, height} : std::vector<double>{0.05, 0.08, height};
    block.xyz = {s.object.xyz.x() + along * c, s.object.xyz.y() + along * d, 0.0};
    block.yaw_deg = yaw;
    s.clutter.push_back(block);
  }
  s.camera.xyz = s.object.xyz + hal::Vec3(1.0, shipped || draws.chance(0.5) ? -1.4 : 1.4, 1.25);
  s.camera.look_at = s.object.xyz + hal::Vec3(0.05, 0.0, 0.05);
  s.partner.grasp = {0.5 * length - 0.08, 0.0, 2.0 * radius};
  return soon(s);
}

Scenario chair_layout(int index, std::uint64_t seed) {
  Draws draws(sim_hal::hash(seed, 7400, static_cast<std::uint64_t>(index)), 7400);
  Scenario s;
  s.name = fmt::format("chair {}", index);
  s.object.kind = "chair";
  const bool shipped = index == 0;
  const double width = shipped ? 0.44 : draws.between(0.40, 0.48);
  const double depth = shipped ? 0.42 : draws.between(0.38, 0.46);
  const double height = shipped ? 0.85 : draws.between(0.80, 0.92);
  s.object.size = {width, depth, height};
  s.object.mass = shipped ? 4.0 : draws.between(3.0, 5.0);
  s.object.friction = shipped ? 0.7 : draws.between(0.6, 0.9);
  const double bearing = shipped ? 0.0 : draws.between(-0.12, 0.12);
  const double away = (shipped ? 0.71 : draws.between(0.66, 0.78)) + 0.5 * depth;
  s.object.xyz = {away * std::cos(bearing), away * std::sin(bearing), 0.0};
  s.object.yaw_deg = 90.0 + (shipped ? 0.0 : hal::rad_to_deg(bearing) + draws.between(-15.0, 15.0));
  s.camera.xyz = s.object.xyz + hal::Vec3(0.28, shipped || draws.chance(0.5) ? -1.8 : 1.8, 1.5);
  s.camera.look_at = s.object.xyz + hal::Vec3(-0.02, 0.0, 0.35);
  s.partner.grasp = {(shipped ? 0.0 : draws.between(-0.2, 0.2)) * width, -0.5 * depth + 0.0175, height};
  return soon(s);
}

Scenario seen_from(View view, Scenario scenario) {
  if (view == View::Side) {
    scenario.camera.xyz = {0.0, -1.6, 1.3};
    scenario.camera.look_at = {0.75, 0.0, 0.35};
  }
  return scenario;
}

sim_hal::Scenario mixed_layout(int index, std::uint64_t seed) {
  const int i = index / 4;
  switch (index % 4) {
    case 0:
      return table_layout(i, seed);
    case 1:
      return box_layout(i, seed);
    case 2:
      return pipe_layout(i, seed);
    default:
      return chair_layout(i, seed);
  }
}

}  // namespace colift::experiments
