#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "hal/depth_camera.hpp"
#include "sim_hal/synthetic/kinect/kinect_noise.hpp"
#include "sim_hal/synthetic/ray_caster.hpp"

namespace colift::sim_hal {

/// What is in front of an emulated video device.
class VideoSource {
 public:
  virtual ~VideoSource() = default;
  /// Pinhole camera of the pictures.
  [[nodiscard]] virtual const hal::CameraIntrinsics& camera() const = 0;
  /// Depth along Cz (m) of every pixel, now; NaN where nothing is seen. `frame` seeds the noise.
  [[nodiscard]] virtual std::vector<float> look(std::uint64_t frame) = 0;
};

/// A scripted world without physics.
class ScriptedVideoSource final : public VideoSource {
 public:
  /// `world` is asked for each picture, with the time since the first; `noise` unset: an ideal camera.
  ScriptedVideoSource(std::function<World(double t_s)> world, const hal::CameraIntrinsics& camera,
                      const Pose& X_WC, std::optional<KinectNoise> noise, std::uint64_t seed,
                      const hal::Clock& clock);
  [[nodiscard]] const hal::CameraIntrinsics& camera() const override { return camera_; }
  [[nodiscard]] std::vector<float> look(std::uint64_t frame) override;

 private:
  std::function<World(double)> world_;
  hal::CameraIntrinsics camera_;
  std::optional<KinectNoise> noise_;
  std::uint64_t seed_;
  const hal::Clock& clock_;
  std::optional<hal::Timestamp> began_;
  RayCaster caster_;
};

}  // namespace colift::sim_hal
