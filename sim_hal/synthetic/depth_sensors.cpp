#include "sim_hal/synthetic/depth_sensors.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "sim_hal/synthetic/hash_random.hpp"
#include "sim_hal/synthetic/kinect/kinect_noise.hpp"

namespace colift::sim_hal {
namespace {

constexpr float kNothing = std::numeric_limits<float>::quiet_NaN();

// Active stereo (RealSense D435 at 640 x 480): 50 mm baseline, disparities matched over windows of about 9
// pixels. The spread of the disparity is chosen so that planes show what 11 x 11 and 48 x 48 pixel patches of
// shared recordings 07 to 10 do: 0.8 and 2 times the Kinect's noise.
constexpr double kBaseline_m = 0.050, kFineNoise_px = 0.05, kWavyNoise_px = 0.07;
constexpr int kWindow = 4, kWave_px = 12;
constexpr float kMinIncidence = 0.10f;
// Time of flight (Azure Kinect, narrow field of view): 1.5 mm, growing with distance and darkness.
constexpr double kTofNoise_m = 0.0012, kTofNoisePerM = 0.0006;

double gaussian(std::uint64_t seed, std::uint64_t stream, std::uint64_t index) {
  const double u = std::max(1e-12, unit(hash(seed, stream, 2 * index)));
  return std::sqrt(-2.0 * std::log(u)) * std::cos(2.0 * M_PI * unit(hash(seed, stream, 2 * index + 1)));
}

// smooth noise: Gaussian values on a grid, bilinear between them
double wave(std::uint64_t seed, int u, int v) {
  const int i = u / kWave_px, k = v / kWave_px;
  const double a = static_cast<double>(u % kWave_px) / kWave_px,
               b = static_cast<double>(v % kWave_px) / kWave_px;
  const auto at = [&](int x, int y) { return gaussian(seed, 71, static_cast<std::uint64_t>(y * 1000 + x)); };
  return (1 - b) * ((1 - a) * at(i, k) + a * at(i + 1, k)) +
         b * ((1 - a) * at(i, k + 1) + a * at(i + 1, k + 1));
}

// mean of the inverse depths in a window: disparities, as the matcher sees them
std::vector<float> smeared(const Rendering& r, int reach) {
  const int w = r.intrinsics.width, h = r.intrinsics.height;
  std::vector<float> inverse(r.depth_m.size()), rows(r.depth_m.size(), kNothing),
      out(r.depth_m.size(), kNothing);
  for (std::size_t i = 0; i < inverse.size(); ++i) inverse[i] = 1.0f / r.depth_m[i];
  const auto blur = [reach](const float* in, float* to, int n, int step) {
    for (int i = 0; i < n; ++i) {
      if (std::isnan(in[i * step])) continue;
      float sum = 0.0f;
      int count = 0;
      for (int k = std::max(0, i - reach); k <= std::min(n - 1, i + reach); ++k) {
        if (std::isnan(in[k * step])) continue;
        sum += in[k * step];
        ++count;
      }
      to[i * step] = sum / static_cast<float>(count);
    }
  };
  for (int v = 0; v < h; ++v) blur(inverse.data() + v * w, rows.data() + v * w, w, 1);
  for (int u = 0; u < w; ++u) blur(rows.data() + u, out.data() + u, h, w);
  return out;
}

void active_stereo(const Rendering& r, std::uint64_t seed, hal::DepthFrame& frame) {
  const int w = r.intrinsics.width, h = r.intrinsics.height;
  const std::vector<float> inverse = smeared(r, kWindow);
  const double disparity_per_inverse = r.intrinsics.fx * kBaseline_m;
  for (int v = 0; v < h; ++v) {
    for (int u = 0; u < w; ++u) {
      const auto i = static_cast<std::size_t>(v * w + u);
      const float true_depth = r.depth_m[i];
      // the right camera does not see a strip to the left of whatever stands in front
      if (u + 1 < w && r.depth_m[i + 1] < true_depth - 0.05f) {
        const double strip = disparity_per_inverse * (1.0 / static_cast<double>(r.depth_m[i + 1]) -
                                                      1.0 / static_cast<double>(true_depth));
        for (int k = std::max(0, u - static_cast<int>(0.5 * strip)); k <= u; ++k)
          frame.depth_m[static_cast<std::size_t>(v * w + k)] = kNothing;
        continue;
      }
      if (std::isnan(inverse[i]) || r.cos_incidence[i] < kMinIncidence) continue;
      if (unit(hash(seed, 72, i)) < 0.002) continue;
      const double disparity = static_cast<double>(inverse[i]) * disparity_per_inverse +
                               kFineNoise_px * gaussian(seed, 70, i) + kWavyNoise_px * wave(seed, u, v);
      if (disparity < 2.0) continue;
      const double depth = disparity_per_inverse / disparity;
      frame.depth_m[i] = static_cast<float>(std::round(1000.0 * depth) / 1000.0);
    }
  }
}

void time_of_flight(const Rendering& r, std::uint64_t seed, hal::DepthFrame& frame) {
  const int w = r.intrinsics.width, h = r.intrinsics.height;
  for (int v = 0; v < h; ++v) {
    for (int u = 0; u < w; ++u) {
      const auto i = static_cast<std::size_t>(v * w + u);
      if (std::isnan(r.depth_m[i])) continue;
      // the lamp's field is round
      const double x = (u - r.intrinsics.cx) / w, y = (v - r.intrinsics.cy) / h;
      if (x * x + y * y > 0.42) continue;
      double depth = static_cast<double>(r.depth_m[i]);
      const bool edge = u + 1 < w && std::abs(r.depth_m[i + 1] - r.depth_m[i]) > 0.04f;
      if (edge) depth += unit(hash(seed, 81, i)) * static_cast<double>(r.depth_m[i + 1] - r.depth_m[i]);
      const double dark = static_cast<double>(r.reflectivity[static_cast<std::size_t>(r.shape[i])]) *
                          static_cast<double>(r.cos_incidence[i]);
      if (dark < 0.02) continue;
      const double sigma =
          (kTofNoise_m + kTofNoisePerM * depth * depth) / std::sqrt(std::min(1.0, 2.0 * dark));
      depth += sigma * gaussian(seed, 80, i);
      frame.depth_m[i] = static_cast<float>(std::round(1000.0 * depth) / 1000.0);
    }
  }
}

}  // namespace

std::string_view name_of(DepthSensor sensor) {
  switch (sensor) {
    case DepthSensor::Kinect:
      return "kinect";
    case DepthSensor::Xtion:
      return "xtion";
    case DepthSensor::ActiveStereo:
      return "active-stereo";
    case DepthSensor::TimeOfFlight:
      return "time-of-flight";
  }
  return "?";
}

hal::CameraIntrinsics intrinsics_of(DepthSensor sensor) {
  switch (sensor) {
    case DepthSensor::ActiveStereo:
      return {640, 480, 617.0, 617.0, 319.0, 243.0};
    case DepthSensor::TimeOfFlight:
      return {640, 576, 505.0, 505.0, 320.0, 288.0};
    case DepthSensor::Xtion:
      return {640, 480, 525.0, 525.0, 319.5, 239.5};
    case DepthSensor::Kinect:
      break;
  }
  return {};
}

hal::DepthFrame measure_with(DepthSensor sensor, const Rendering& truth, std::uint64_t seed) {
  hal::DepthFrame frame;
  if (sensor == DepthSensor::Kinect || sensor == DepthSensor::Xtion) {
    KinectNoise light;
    light.holes = sensor == DepthSensor::Kinect;
    frame = measure(truth, light, seed);
  } else {
    frame.intrinsics = truth.intrinsics;
    frame.depth_m.assign(truth.depth_m.size(), kNothing);
    if (sensor == DepthSensor::ActiveStereo)
      active_stereo(truth, seed, frame);
    else
      time_of_flight(truth, seed, frame);
  }
  for (std::size_t i = 0; i < frame.depth_m.size(); ++i)  // a window, a mirror
    if (truth.shape[i] >= 0 && truth.reflectivity[static_cast<std::size_t>(truth.shape[i])] <= 0.0f)
      frame.depth_m[i] = kNothing;
  return frame;
}

}  // namespace colift::sim_hal
