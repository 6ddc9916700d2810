#include "sim_hal/emulator/mujoco/camera_world_source.hpp"

#include "sim_hal/mujoco/devices/sim_devices.hpp"
#include "sim_hal/synthetic/hash_random.hpp"

namespace colift::sim_hal {
namespace {

constexpr std::uint64_t kNoiseStream = 71;

}  // namespace

CameraWorldSource::CameraWorldSource(const SimWorld& world, const SimEmitter& emitter)
    : world_(world),
      emitter_(emitter),
      X_WC_(camera_pose(world.scenario().camera)),
      caster_(hal::CameraIntrinsics{}, X_WC_) {}

void CameraWorldSource::turn(double angle_rad) {
  X_WC_ = camera_pose(world_.scenario().camera) * Eigen::AngleAxisd(angle_rad, Vec3::UnitX());
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
  const hal::DepthFrame image = world_.scenario().camera.noise == "none"
                                    ? measure_ideal(truth)
                                    : measure(truth, KinectNoise{}, hash(world_.seed(), kNoiseStream, frame));
  e.codes = kinect_codes(image.depth_m);
  e.up_C = up_in(X_WC_);
  return e;
}

}  // namespace colift::sim_hal
