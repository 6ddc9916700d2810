#include "sim_hal/emulator/camera/camera_source.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "sim_hal/synthetic/hash_random.hpp"
#include "sim_hal/synthetic/kinect/kinect_code.hpp"

namespace colift::sim_hal {
namespace {

constexpr int kWidth = 640, kHeight = 480, kInfraredHeight = 488;
constexpr int kOffsetU = 5, kOffsetV = 4;  // half of the correlation window
constexpr std::uint16_t kNothing = 2047;
constexpr std::uint64_t kStream = 83;

/// The code of every whole millimetre up to 10 m.
const std::array<std::uint16_t, 10'000>& code_of_mm() {
  static const auto table = [] {
    std::array<std::uint16_t, 10'000> t{};
    t.fill(kNothing);
    const auto& z = kinect_depths_m();
    for (int raw = 0; raw < kKinectCodes; ++raw) {
      const auto mm = static_cast<std::size_t>(
          std::lround(1000.0 * static_cast<double>(z[static_cast<std::size_t>(raw) + 1])));
      if (mm < t.size()) t[mm] = static_cast<std::uint16_t>(raw);
    }
    // millimetres that no code has: the code before, which is nearer
    for (std::size_t mm = 1; mm < t.size(); ++mm)
      if (t[mm] == kNothing) t[mm] = t[mm - 1];
    return t;
  }();
  return table;
}

}  // namespace

std::vector<std::uint16_t> kinect_codes(const std::vector<float>& depth_m) {
  const auto& table = code_of_mm();
  std::vector<std::uint16_t> codes(depth_m.size(), kNothing);
  for (std::size_t i = 0; i < depth_m.size(); ++i) {
    const float z = depth_m[i];
    if (!(z > 0.0f && z < 9.999f)) continue;
    codes[i] = table[static_cast<std::size_t>(std::lround(1000.0f * z))];
  }
  return codes;
}

Vec3 up_in(const Pose& X_WC) {
  return X_WC.linear().transpose() * Vec3::UnitZ();
}

std::vector<std::uint16_t> CameraSource::infrared(const CameraExposure& exposure) {
  // the projector's dots on whatever reflects them: brighter when it is near, speckled
  const auto& z = kinect_depths_m();
  std::vector<std::uint16_t> image(static_cast<std::size_t>(kWidth) * kInfraredHeight, 20);
  for (int v = 0; v < kHeight; ++v)
    for (int u = 0; u + kOffsetU < kWidth; ++u) {
      const auto i = static_cast<std::size_t>(v) * kWidth + static_cast<std::size_t>(u);
      const std::uint16_t code = exposure.codes[i];
      if (code >= kKinectCodes) continue;
      const double d = static_cast<double>(z[static_cast<std::size_t>(code) + 1]);
      const double dot = (hash(7, kStream, i) & 7U) == 0 ? 1.0 : 0.25;
      const double light = std::min(1023.0, 20.0 + 500.0 * dot / std::max(0.25, d * d));
      image[static_cast<std::size_t>(v + kOffsetV) * kWidth + static_cast<std::size_t>(u + kOffsetU)] =
          static_cast<std::uint16_t>(light);
    }
  return image;
}

ScriptedCameraSource::ScriptedCameraSource(std::function<World(double t_s)> world, const Pose& X_WC,
                                           std::optional<KinectNoise> noise, std::uint64_t seed,
                                           const hal::Clock& clock)
    : world_(std::move(world)),
      X_WC_(X_WC),
      X_WC_first_(X_WC),
      noise_(noise),
      seed_(seed),
      clock_(clock),
      caster_(hal::CameraIntrinsics{}, X_WC) {}

void ScriptedCameraSource::turn(double angle_rad) {
  X_WC_ = X_WC_first_ * Eigen::AngleAxisd(angle_rad, Vec3::UnitX());
  caster_ = RayCaster(hal::CameraIntrinsics{}, X_WC_);
}

CameraExposure ScriptedCameraSource::look(std::uint64_t frame) {
  CameraExposure e;
  e.at = clock_.now();
  if (!began_) began_ = e.at;
  const Rendering& truth = caster_.cast(world_(hal::seconds(e.at - *began_)));
  const hal::DepthFrame image =
      noise_ ? measure(truth, *noise_, hash(seed_, kStream, frame)) : measure_ideal(truth);
  e.codes = kinect_codes(image.depth_m);
  e.up_C = up_in(X_WC_);
  return e;
}

}  // namespace colift::sim_hal
