#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace colift::hal::kinect {

/// What a device says of its own geometry; the nominal Kinect v1.
struct DepthConstants {
  double emitter_cm = 7.5;      ///< From the camera to the projector.
  double reference_cm = 120.0;  ///< To the plane that its pattern was taken on.
  double pixel_cm = 0.1042;     ///< Of a pixel on that plane, at 1280 across.
  double shift = 200.0;
};

/// Whether they can be a Kinect's at all; what a broken device or process says is not used.
[[nodiscard]] bool plausible(const DepthConstants& c);

/// Depth along Cz of every 11-bit code (m), whole millimetres as the device's own conversion has them:
///   m = ((raw - 4 C) / 4 - 0.375) P,  z = trunc(10 (m R / (E - m) + R)) mm
/// (OpenKinect/libfreenect, registration). NaN for 2047, for codes at or beyond infinity, from 10 m on, and
/// nearer than 0.4 m, where a Kinect measures nothing: an image of zeros shows nothing.
class DepthTable {
 public:
  explicit DepthTable(const DepthConstants& constants = {});

  /// NaN for anything beyond 11 bits too.
  [[nodiscard]] float metres(std::uint16_t raw) const { return z_m_[raw < z_m_.size() ? raw : 2047]; }
  /// As many depths as codes.
  void convert(std::span<const std::uint16_t> raw, std::vector<float>& depth_m) const;

  /// The code whose depth is nearest; kNoDepth for NaN and for what no code reaches.
  [[nodiscard]] std::uint16_t nearest_code(float depth_m) const;

  [[nodiscard]] const DepthConstants& constants() const { return constants_; }

 private:
  DepthConstants constants_;
  std::array<float, 2048> z_m_{};
  double k_mm_ = 0.0, at_infinity_ = 0.0;
};

}  // namespace colift::hal::kinect
