#include "tools/experiments/trials/asked_partner.hpp"

#include <algorithm>

#include "sim_hal/synthetic/hash_random.hpp"

namespace colift::experiments {
namespace {

constexpr double kBeside_m = 0.03;
constexpr std::uint64_t kStream = 7960;

}  // namespace

sim_hal::Scenario partner_goes_to(sim_hal::Scenario scenario, const hal::Vec3& place, std::uint64_t seed) {
  sim_hal::Draws draws(seed, kStream);
  hal::Vec3 at = sim_hal::object_pose(scenario.object).inverse() * place;
  for (int axis = 0; axis < 2; ++axis) {
    const double half = 0.5 * scenario.object.size[static_cast<std::size_t>(axis)];
    at[axis] = std::clamp(at[axis] + draws.between(-kBeside_m, kBeside_m), -half, half);
  }
  scenario.partner.grasp = at;
  return scenario;
}

}  // namespace colift::experiments
