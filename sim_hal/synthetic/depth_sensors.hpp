#pragma once

#include <cstdint>
#include <string_view>

#include "hal/depth_camera.hpp"
#include "sim_hal/synthetic/ray_caster.hpp"

namespace colift::sim_hal {

/// Kinds of depth cameras whose images differ in more than their noise.
enum class DepthSensor {
  Kinect,        ///< Structured light, Kinect v1: sim_hal/synthetic/kinect.
  Xtion,         ///< The same principle without the Kinect's empty columns; finer edges.
  ActiveStereo,  ///< RealSense D4xx: smeared edges, noise that hangs together over many pixels.
  TimeOfFlight,  ///< Kinect v2, Azure Kinect: fine noise, depths between both sides of an edge, dark corners.
};

[[nodiscard]] std::string_view name_of(DepthSensor sensor);
[[nodiscard]] hal::CameraIntrinsics intrinsics_of(DepthSensor sensor);

/// What such a camera would measure of a rendering. Same rendering, sensor and seed: same bits.
[[nodiscard]] hal::DepthFrame measure_with(DepthSensor sensor, const Rendering& truth, std::uint64_t seed);

}  // namespace colift::sim_hal
