#include "sim_hal/emulator/mujoco/camera_world_source.hpp"

#include "sim_hal/mujoco/devices/sim_devices.hpp"
#include "sim_hal/synthetic/hash_random.hpp"

namespace colift::sim_hal {
namespace {

constexpr std::uint64_t kNoiseStream = 71, kStreams = 100;

}  // namespace

CameraWorldSource::CameraWorldSource(const SimWorld& world, std::size_t number, const SimEmitter& emitter)
    : world_(world),
      place_(number == 0 ? world.scenario().camera : world.scenario().more_cameras.at(number - 1)),
      noise_stream_(kNoiseStream + kStreams * number),
      emitter_(emitter),
      X_WC_(camera_pose(place_)),
      caster_(hal::CameraIntrinsics{}, X_WC_),
      overlap_(world, number) {}

void CameraWorldSource::turn(double angle_rad) {
  X_WC_ = camera_pose(place_) * Eigen::AngleAxisd(angle_rad, Vec3::UnitX());
  caster_ = RayCaster(hal::CameraIntrinsics{}, X_WC_);
  if (infrared_) infrared_->move_to(X_WC_);
}

std::vector<std::uint16_t> CameraWorldSource::infrared(const CameraExposure&) {
  if (!infrared_) {
    infrared_.emplace(world_, emitter_);
    infrared_->move_to(X_WC_);
  }
  return infrared_->expose(frame_).brightness;
}

CameraExposure CameraWorldSource::look(std::uint64_t frame) {
  frame_ = frame;
  CameraExposure e;
  e.at = world_.clock().now();
  const Rendering& truth = caster_.cast(world_.shapes());
  const bool ideal = place_.noise == "none";
  hal::DepthFrame image =
      ideal ? measure_ideal(truth) : measure(truth, KinectNoise{}, hash(world_.seed(), noise_stream_, frame));
  if (!ideal) overlap_.apply(image, frame);
  e.codes = kinect_codes(image.depth_m);
  e.up_C = up_in(X_WC_);
  return e;
}

}  // namespace colift::sim_hal
