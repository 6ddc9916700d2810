#include "sim_hal/emulator/mujoco/video_world_source.hpp"

#include "sim_hal/mujoco/devices/sim_devices.hpp"
#include "sim_hal/synthetic/hash_random.hpp"

namespace colift::sim_hal {
namespace {

constexpr std::uint64_t kNoiseStream = 73;

}  // namespace

VideoWorldSource::VideoWorldSource(const SimWorld& world, const hal::CameraIntrinsics& camera)
    : world_(world), camera_(camera), caster_(camera, camera_pose(world.scenario().camera)) {}

std::vector<float> VideoWorldSource::look(std::uint64_t frame) {
  const Rendering& truth = caster_.cast(world_.shapes());
  return (world_.scenario().camera.noise == "none"
              ? measure_ideal(truth)
              : measure(truth, KinectNoise{}, hash(world_.seed(), kNoiseStream, frame)))
      .depth_m;
}

}  // namespace colift::sim_hal
