#include "sim_hal/synthetic/infrared_scene.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "hal/types/units.hpp"
#include "sim_hal/synthetic/hash_random.hpp"

namespace colift::sim_hal {
namespace {

constexpr std::uint64_t kSpeckleStream = 81, kNoiseStream = 82, kPlaceStream = 83;
constexpr double kBrightest = 1023.0;
constexpr double kAmbient = 25.0, kProjector = 150.0;  // brightness of a white wall at 1 m: 175 on average
constexpr double kBehind_m = 0.03;                     // the diode sits in the palm's cover

/// Normal numbers from a table: of 4096 equally likely ones, as many as a 10 bit image can tell apart.
const std::array<float, 4096>& normal_table() {
  static const std::array<float, 4096> table = [] {
    std::array<float, 4096> t{};
    for (std::size_t i = 0; i < t.size() / 2; ++i) {
      // Box and Muller over a grid: the squares add up as they should
      const double u = (static_cast<double>(i) + 0.5) / static_cast<double>(t.size() / 2);
      const double r = std::sqrt(-2.0 * std::log(u));
      const double a = 2.0 * std::numbers::pi * unit(hash(7, kNoiseStream, i));
      t[2 * i] = static_cast<float>(r * std::cos(a));
      t[2 * i + 1] = static_cast<float>(r * std::sin(a));
    }
    return t;
  }();
  return table;
}

double normal(std::uint64_t seed, std::uint64_t stream, std::uint64_t index) {
  return static_cast<double>(normal_table()[hash(seed, stream, index) >> 52]);
}

void add_spot(std::vector<float>& light, int width, int height, const Eigen::Vector2d& at, double peak,
              double sigma) {
  const int reach = static_cast<int>(std::ceil(5.0 * sigma));
  const int u0 = static_cast<int>(std::lround(at.x())), v0 = static_cast<int>(std::lround(at.y()));
  for (int v = std::max(0, v0 - reach); v <= std::min(height - 1, v0 + reach); ++v)
    for (int u = std::max(0, u0 - reach); u <= std::min(width - 1, u0 + reach); ++u) {
      const double r2 = (Eigen::Vector2d(u, v) - at).squaredNorm();
      light[static_cast<std::size_t>(v * width + u)] +=
          static_cast<float>(peak * std::exp(-0.5 * r2 / (sigma * sigma)));
    }
}

}  // namespace

std::optional<Eigen::Vector2d> spot_of(const Rendering& truth, const Emitter& emitter) {
  const auto& k = truth.intrinsics;
  const Vec3 p_C = truth.X_WC.inverse() * emitter.at_W;
  if (p_C.z() < 0.1) return std::nullopt;
  const Vec3 to_camera = (truth.X_WC.translation() - emitter.at_W).normalized();
  if (emitter.towards_W.dot(to_camera) < std::cos(hal::deg_to_rad(emitter.view_deg))) return std::nullopt;
  const Eigen::Vector2d at(k.fx * p_C.x() / p_C.z() + k.cx, k.fy * p_C.y() / p_C.z() + k.cy);
  const long u = std::lround(at.x()), v = std::lround(at.y());
  if (u < 0 || v < 0 || u >= k.width || v >= k.height) return std::nullopt;
  const float before = truth.depth_m[static_cast<std::size_t>(v * k.width + u)];
  if (static_cast<double>(before) < p_C.z() - kBehind_m) return std::nullopt;  // NaN: nothing before it
  return at;
}

hal::InfraredFrame expose_infrared(const Rendering& truth, const std::optional<Emitter>& emitter,
                                   const std::vector<StrayLight>& stray, const InfraredNoise& noise,
                                   std::uint64_t seed) {
  const auto& k = truth.intrinsics;
  hal::InfraredFrame out;
  out.intrinsics = k;
  out.width = k.width;
  out.height = k.height;
  const std::size_t n = truth.depth_m.size();
  std::vector<float> light(n);
  for (std::size_t i = 0; i < n; ++i) {
    double value = kAmbient;
    if (truth.shape[i] >= 0) {
      const auto z = static_cast<double>(truth.depth_m[i]);
      // dots of the projector: the same pixel has the same one in every image
      const double speckle = 2.0 * unit(hash(3, kSpeckleStream, i));
      const auto white = static_cast<double>(truth.reflectivity[static_cast<std::size_t>(truth.shape[i])]);
      value += kProjector * white * static_cast<double>(truth.cos_incidence[i]) * speckle * speckle / (z * z);
    }
    light[i] = static_cast<float>(value);
  }
  if (emitter) {
    if (auto at = spot_of(truth, *emitter)) {
      const double z = (truth.X_WC.inverse() * emitter->at_W).z();
      const double cosine = emitter->towards_W.dot((truth.X_WC.translation() - emitter->at_W).normalized());
      at->x() += noise.spot_px * normal(noise.pose_seed, kPlaceStream, 0);
      at->y() += noise.spot_px * normal(noise.pose_seed, kPlaceStream, 1);
      // optics blur by a pixel, and the diffuse cap is 4 mm wide
      const double sigma = std::hypot(1.0, 0.002 * k.fx / z);
      add_spot(light, k.width, k.height, *at, emitter->peak * cosine / (z * z), sigma);
    }
  }
  for (const StrayLight& s : stray) add_spot(light, k.width, k.height, s.pixel, s.peak, s.sigma_px);
  out.brightness.resize(n);
  const std::uint64_t tape = hash(seed, kNoiseStream, 0);
  for (std::size_t i = 0; i < n; ++i) {
    const auto l = static_cast<double>(light[i]);
    const double sigma = noise.readout + noise.shot * std::sqrt(l);
    const auto z = static_cast<double>(normal_table()[hash(tape, kNoiseStream, i) >> 52]);
    out.brightness[i] = static_cast<std::uint16_t>(std::lround(std::clamp(l + sigma * z, 0.0, kBrightest)));
  }
  return out;
}

}  // namespace colift::sim_hal
