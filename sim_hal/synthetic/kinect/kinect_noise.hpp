#pragma once

#include <cstdint>

#include "hal/depth_camera.hpp"
#include "sim_hal/synthetic/ray_caster.hpp"

namespace colift::sim_hal {

/// Noise of a Kinect v1. Each effect can be switched off on its own, to see what an algorithm stumbles over.
struct KinectNoise {
  bool axial = true;          ///< Gaussian depth noise growing with distance and angle.
  bool lateral = true;        ///< Ragged edges: the ray of a pixel wanders by under a pixel.
  bool quantisation = true;   ///< Depth from the integer raw code.
  bool shadow = true;         ///< No data where the projector, 7.5 cm beside the camera, does not reach.
  bool flying_pixels = true;  ///< Depths between foreground and background along edges.
  bool holes = true;          ///< No data on grazing and dark surfaces, speckle, empty border columns.
};

/// What a Kinect would measure of a rendering. Same rendering, noise and seed: same bits.
[[nodiscard]] hal::DepthFrame measure(const Rendering& truth, const KinectNoise& noise, std::uint64_t seed);

/// The rendering itself as a frame.
[[nodiscard]] hal::DepthFrame measure_ideal(const Rendering& truth);

}  // namespace colift::sim_hal
