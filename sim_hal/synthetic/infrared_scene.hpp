#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "hal/infrared_camera.hpp"
#include "sim_hal/synthetic/ray_caster.hpp"

namespace colift::sim_hal {

/// A light-emitting diode of wide angle, lit.
struct Emitter {
  Vec3 at_W = Vec3::Zero();
  Vec3 towards_W = Vec3::UnitZ();  ///< Unit vector of its axis.
  double view_deg = 65.0;          ///< It shines this far from its axis.
  double peak = 3200.0;            ///< Brightness of its spot's middle on its axis at 1 m; 1023 is the most.
};

/// A spot of light in the image that is no emitter: a reflection, the sun on metal.
struct StrayLight {
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
  double peak = 0.0, sigma_px = 1.5;
};

/// Noise of the infrared image.
struct InfraredNoise {
  double readout = 3.0;  ///< Standard deviation of every pixel.
  double shot = 0.3;     ///< More of it by this times the square root of the brightness.
  double spot_px = 0.0;  ///< Displacement of the spot's middle, per axis, the same in all images of a pose.
  std::uint64_t pose_seed = 0;  ///< Which displacement.
};

/// Where the emitter is in the image, if the camera sees it: within its angle, in the image, nothing before
/// it.
[[nodiscard]] std::optional<Eigen::Vector2d> spot_of(const Rendering& truth, const Emitter& emitter);

/// What a Kinect's infrared camera would see of a rendering (made with the infrared image's intrinsics):
/// the projector's speckle on everything, the emitter's Gaussian spot, cut off at 1023, noise. Same input and
/// seed: same bits.
[[nodiscard]] hal::InfraredFrame expose_infrared(const Rendering& truth,
                                                 const std::optional<Emitter>& emitter,
                                                 const std::vector<StrayLight>& stray,
                                                 const InfraredNoise& noise, std::uint64_t seed);

}  // namespace colift::sim_hal
