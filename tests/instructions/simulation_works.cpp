// Frames of the synthetic Kinect and steps of the physics, on the built-in table.
#include <chrono>
#include <cstdlib>
#include <memory>

#include "counted_work.hpp"
#include "sim_hal/mujoco/devices/sim_camera.hpp"
#include "sim_hal/mujoco/sim_world.hpp"
#include "sim_hal/synthetic/kinect/kinect_noise.hpp"

namespace colift::counted {
namespace {

using std::chrono::milliseconds;

constexpr int kHolding_ms = 5000;  // the person is there and holds the table
constexpr auto kFrame = milliseconds(33);

std::shared_ptr<sim_hal::SimWorld> world_at(int ms) {
  auto made = sim_hal::SimWorld::make(sim_hal::built_in_scenario(), hal::built_in_robot(), 1, {});
  if (!made) std::abort();
  std::shared_ptr<sim_hal::SimWorld> world = std::move(*made);
  world->advance(milliseconds(ms));
  return world;
}

}  // namespace

std::vector<Work> simulation_works() {
  std::vector<Work> works;
  works.push_back({"sim_frame", "a frame of the simulated camera: rays of what moved, and noise", [] {
                     auto world = world_at(kHolding_ms);
                     auto caster = std::make_shared<sim_hal::RayCaster>(
                         hal::CameraIntrinsics{}, sim_hal::camera_pose(world->scenario().camera));
                     (void)caster->cast(world->shapes());
                     world->advance(kFrame);
                     return [world, caster] { (void)sim_hal::measure(caster->cast(world->shapes()), {}, 1); };
                   }});
  works.push_back({"sim_physics", "33 ms of physics while the person holds", [] {
                     auto world = world_at(kHolding_ms);
                     return [world] { world->advance(kFrame); };
                   }});
  return works;
}

}  // namespace colift::counted
