#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "hal/depth_camera.hpp"
#include "sim_hal/synthetic/kinect/kinect_noise.hpp"
#include "sim_hal/synthetic/ray_caster.hpp"

namespace colift::sim_hal {

/// What an emulated Kinect's sensors tell at one moment.
struct CameraExposure {
  hal::Timestamp at{0};
  std::vector<std::uint16_t> codes;  ///< 640 * 480, 11 bits.
  Vec3 up_C = -Vec3::UnitY();        ///< Against gravity.
};

/// What is in front of an emulated Kinect.
class CameraSource {
 public:
  virtual ~CameraSource() = default;
  /// Now. `frame` seeds the noise.
  [[nodiscard]] virtual CameraExposure look(std::uint64_t frame) = 0;
  /// Against gravity, at this moment.
  [[nodiscard]] virtual Vec3 up_C() const = 0;
  /// The camera is knocked: turned about its Cx (rad), against where it stood at first.
  virtual void turn(double angle_rad) = 0;
  /// The infrared image (640 * 488, ten bits) that goes with the exposure.
  [[nodiscard]] virtual std::vector<std::uint16_t> infrared(const CameraExposure& exposure);
};

/// Raw codes of a depth image: of each depth the code that has it, 2047 where nothing was seen.
[[nodiscard]] std::vector<std::uint16_t> kinect_codes(const std::vector<float>& depth_m);

/// Against gravity in C.
[[nodiscard]] Vec3 up_in(const Pose& X_WC);

/// A scripted world without physics.
class ScriptedCameraSource final : public CameraSource {
 public:
  /// `world` is asked for each frame, with the time since the first; `noise` unset: an ideal camera.
  ScriptedCameraSource(std::function<World(double t_s)> world, const Pose& X_WC,
                       std::optional<KinectNoise> noise, std::uint64_t seed, const hal::Clock& clock);
  [[nodiscard]] CameraExposure look(std::uint64_t frame) override;
  [[nodiscard]] Vec3 up_C() const override { return up_in(X_WC_); }
  void turn(double angle_rad) override;

 private:
  std::function<World(double)> world_;
  Pose X_WC_, X_WC_first_;
  std::optional<KinectNoise> noise_;
  std::uint64_t seed_;
  const hal::Clock& clock_;
  std::optional<hal::Timestamp> began_;
  RayCaster caster_;
};

}  // namespace colift::sim_hal
