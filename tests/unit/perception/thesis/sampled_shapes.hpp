#pragma once

#include <cstdint>
#include <vector>

#include "hal/types/geometry.hpp"

namespace colift::test {

/// Points on surfaces at a fixed spacing, each off its surface by less than `noise_m`: what a tidy sensor
/// would see.
class SampledShapes {
 public:
  explicit SampledShapes(double spacing_m = 0.005, double noise_m = 0.002)
      : spacing_m_(spacing_m), noise_m_(noise_m) {}

  /// A rectangle from a corner along two perpendicular vectors.
  SampledShapes& rectangle(const hal::Vec3& corner, const hal::Vec3& a, const hal::Vec3& b) {
    const hal::Vec3 n = a.cross(b).normalized();
    const auto steps = [&](const hal::Vec3& side) {
      return static_cast<int>(side.norm() / spacing_m_ + 0.5);
    };
    for (int i = 0; i <= steps(a); ++i)
      for (int j = 0; j <= steps(b); ++j) {
        const hal::Vec3 p = corner + a.normalized() * (i * spacing_m_) + b.normalized() * (j * spacing_m_);
        points.push_back((p + n * (noise_m_ * wobble())).cast<float>());
      }
    return *this;
  }

  /// The faces of a box that an eye far along +x, +y and +z sees.
  SampledShapes& box(const hal::Vec3& low, const hal::Vec3& size) {
    const hal::Vec3 x{size.x(), 0, 0}, y{0, size.y(), 0}, z{0, 0, size.z()};
    return rectangle(low + z, x, y).rectangle(low + x, y, z).rectangle(low + y, x, z);
  }

  std::vector<Eigen::Vector3f> points;

 private:
  /// Uniform in -1 to 1, the same on every machine.
  double wobble() {
    state_ = state_ * 6364136223846793005ull + 1442695040888963407ull;
    return static_cast<double>(state_ >> 11) * 0x1p-52 - 1.0;
  }

  double spacing_m_, noise_m_;
  std::uint64_t state_ = 42;
};

}  // namespace colift::test
