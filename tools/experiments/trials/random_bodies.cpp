#include "tools/experiments/trials/random_bodies.hpp"

#include <fmt/format.h>

#include <cmath>

#include "hal/types/units.hpp"
#include "sim_hal/scenario/random_scenario.hpp"
#include "sim_hal/synthetic/hash_random.hpp"

namespace colift::experiments {
namespace {

using sim_hal::Draws;
using sim_hal::Scenario;

constexpr double kArrives_s = 1.7;
constexpr double kTop_m = 0.025;
constexpr double kLight_kg_m3 = 150.0, kHeavy_kg_m3 = 320.0;  // honeycomb boards to light softwood

void add(Scenario& s, Draws& draws, const hal::Vec3& center, const hal::Vec3& size) {
  sim_hal::ScenarioPart part;
  part.shape = "box";
  part.size = {size.x(), size.y(), size.z()};
  part.xyz = center;
  part.mass = size.prod() * draws.between(kLight_kg_m3, kHeavy_kg_m3);
  s.object.parts.push_back(part);
}

// what stands under the top, which goes from -length/2 to length/2
void add_desk(Scenario& s, Draws& draws, double length, double width, double under) {
  constexpr double kPanel_m = 0.02;
  for (const double side : {-1.0, 1.0})
    add(s, draws, {side * (0.5 * length - 0.06), 0.0, 0.5 * under}, {kPanel_m, 0.9 * width, under});
  const double side = draws.chance(0.5) ? -1.0 : 1.0;
  add(s, draws, {side * (0.5 * length - 0.19), 0.0, under - 0.05}, {0.22, 0.6 * width, 0.10});
}

void add_bench(Scenario& s, Draws& draws, double length, double width, double under) {
  for (const double side : {-1.0, 1.0})
    add(s, draws, {side * (0.5 * length - 0.12), 0.0, 0.5 * under}, {0.06, 0.8 * width, under});
}

void add_trestles(Scenario& s, Draws& draws, double length, double width, double under) {
  for (const double x : {-1.0, 1.0})
    for (const double y : {-1.0, 1.0})
      add(s, draws, {x * (0.5 * length - 0.10), y * (0.5 * width - 0.06), 0.5 * under}, {0.04, 0.04, under});
  add(s, draws, {0.5 * length - 0.10, 0.0, 0.3 * under}, {0.03, width - 0.16, 0.05});
}

}  // namespace

Scenario bodies_layout(int index, std::uint64_t seed) {
  Draws draws(sim_hal::hash(seed, 7700, static_cast<std::uint64_t>(index)), 7700);
  Scenario s;
  s.name = fmt::format("bodies {}", index);
  s.object.kind = "bodies";
  const double length = draws.between(0.65, 0.95), width = draws.between(0.40, 0.65);
  const double height = draws.between(0.40, 0.55), under = height - kTop_m;
  add(s, draws, {0.0, 0.0, height - 0.5 * kTop_m}, {length, width, kTop_m});
  switch (index % 3) {
    case 0:
      add_desk(s, draws, length, width, under);
      break;
    case 1:
      add_bench(s, draws, length, width, under);
      break;
    default:
      add_trestles(s, draws, length, width, under);
  }
  for (const sim_hal::ScenarioPart& part : s.object.parts) s.object.mass += part.mass;
  s.object.friction = draws.between(0.6, 0.9);
  const double bearing = draws.between(-0.25, 0.25), yaw = bearing + draws.between(-0.3, 0.3);
  const double away = draws.between(0.68, 0.82) + 0.5 * length * std::cos(yaw - bearing);
  s.object.xyz = {away * std::cos(bearing), away * std::sin(bearing), 0.0};
  s.object.yaw_deg = hal::rad_to_deg(yaw);
  s.partner.kind = "compliant";
  s.partner.grasp = {0.5 * length, draws.between(-0.2, 0.2) * width, height - 0.5 * kTop_m};
  s.partner.arrives_s = kArrives_s;
  s.object.size = {length, width, height};
  sim_hal::draw_camera(s, draws);
  s.object.size.clear();  // the parts have sizes
  return s;
}

}  // namespace colift::experiments
