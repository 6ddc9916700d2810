#include "perception/motion/object_motion_samples.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <vector>

#include "hal/types/symmetric.hpp"
#include "perception/motion/window_sums.hpp"

namespace colift::perception {
namespace {

constexpr int kBinsPerSide = 3;  // of the faces of a cube around the unit sphere
constexpr int kCentre = 2;       // half the window whose mean is the sample's point

// the oblong ones are for legs and bars
constexpr std::array<Window, 7> kWindows{{{15, 15}, {9, 9}, {3, 15}, {15, 3}, {5, 5}, {2, 9}, {9, 2}}};

// where nothing is flat, something may be round: a thin pipe
constexpr std::array<Window, 3> kRoundWindows{{{7, 7}, {5, 5}, {3, 9}}};

struct Sample {
  Vec3 point, normal;
  double sigma, tilt;
  int bin;
};

int bin_of(const Vec3& n) {
  int axis = 0;
  n.cwiseAbs().maxCoeff(&axis);
  const int face = 2 * axis + (n[axis] > 0 ? 1 : 0);
  const auto cell = [&](int other) {
    const double t = n[(axis + other) % 3] / std::abs(n[axis]);
    return std::min(kBinsPerSide - 1, static_cast<int>(0.5 * (t + 1.0) * kBinsPerSide));
  };
  return (face * kBinsPerSide + cell(1)) * kBinsPerSide + cell(2);
}

InverseDepth inverse_depth(const ReferenceImage& reference, const Target& target) {
  InverseDepth object{std::vector<float>(reference.cloud.size()), reference.cloud.width(),
                      reference.cloud.intrinsics.height};
  for (const std::uint32_t i : target.pixels)
    if (const float z = reference.cloud.depth_m[i]; z > 0) object.values[i] = 1.0f / z;
  return object;
}

class ObjectPixels {
 public:
  ObjectPixels(const ReferenceImage& reference, const Target& target, const NoiseModel& noise,
               const SurfaceSamplingConfig& config)
      : reference_(reference),
        noise_(noise),
        config_(config),
        object_(inverse_depth(reference, target)),
        integrals_(object_) {}

  [[nodiscard]] std::optional<Sample> sample(std::uint32_t pixel) const {
    if (!(object_.values[pixel] > 0)) return std::nullopt;
    const int u = static_cast<int>(pixel) % object_.width, v = static_cast<int>(pixel) / object_.width;
    for (const Window& window : kWindows)
      if (const auto fitted = plane(u, v, window))
        if (auto found = judge<3>(u, v, window, *fitted)) return found;
    for (const Window& window : kRoundWindows)
      if (const auto fitted = curved(u, v, window))
        if (auto found = judge<6>(u, v, window, *fitted)) return found;
    return std::nullopt;
  }

 private:
  struct Fit {
    double a = 0, b = 0, c = 0, rms = 0;  // w = a du + b dv + c at the middle
    double n = 0;
  };

  template <int kTerms>
  [[nodiscard]] bool covered(double n, int wanted) const {
    return n >= 3 * kTerms && n >= config_.min_window_coverage * wanted;
  }

  // Least squares: inverse depth as a plane. nullopt where the window shows too little of the object.
  [[nodiscard]] std::optional<Fit> plane(int u, int v, const Window& window) const {
    const WindowSums s = integrals_.sums(object_, u, v, window);
    if (!covered<3>(s.n, window.pixels())) return std::nullopt;
    // about the mean, where two of the three unknowns are left
    const double mu = s.u / s.n, mv = s.v / s.n;
    const double uu = s.uu - mu * s.u, uv = s.uv - mu * s.v, vv = s.vv - mv * s.v;
    const double wu = s.wu - mu * s.w, wv = s.wv - mv * s.w;
    const double determinant = uu * vv - uv * uv;
    if (!(determinant > 1e-9 * uu * vv)) return std::nullopt;  // a line of pixels has no plane
    const double a = (wu * vv - wv * uv) / determinant, b = (wv * uu - wu * uv) / determinant;
    const double c = (s.w - a * s.u - b * s.v) / s.n;
    const double rms = std::sqrt(std::max(0.0, (s.ww - c * s.w - a * s.wu - b * s.wv) / (s.n - 3)));
    return Fit{a, b, static_cast<double>(object_.values[at(u, v)]) + c, rms, s.n};
  }

  // The same with curvature.
  [[nodiscard]] std::optional<Fit> curved(int u0, int v0, const Window& window) const {
    if (!covered<6>(integrals_.sums(object_, u0, v0, window).n, window.pixels())) return std::nullopt;
    const QuadraticSums s = quadratic_sums(object_, u0, v0, window);
    const Eigen::Matrix<double, 6, 1> x = hal::solve_symmetric<double, 6>(s.normal, s.right);
    Fit fit;
    fit.n = s.n;
    fit.a = x[1], fit.b = x[2], fit.c = static_cast<double>(object_.values[at(u0, v0)]) + x[0];
    fit.rms = std::sqrt(std::max(0.0, (s.squares - x.dot(s.right)) / (fit.n - 6)));
    return fit;
  }

  // The sample at a pixel, where what was fitted to the window is smooth and not too steep.
  template <int kTerms>
  [[nodiscard]] std::optional<Sample> judge(int u0, int v0, const Window& window, const Fit& f) const {
    const auto& k = reference_.cloud.intrinsics;
    if (!(f.c > 0)) return std::nullopt;
    const double z = 1.0 / f.c;
    // averaging over the reference's frames, as far as they are independent
    const double averaged = noise_.sigma(z) / std::sqrt(std::min(reference_.frames, 20));
    const double expected = std::hypot(averaged, config_.noise_floor_m) * f.c * f.c;

    const double ray_x = (u0 - k.cx) / k.fx, ray_y = (v0 - k.cy) / k.fy;
    const Vec3 ray(ray_x, ray_y, 1.0);
    const double A = f.a * k.fx, B = f.b * k.fy;
    const Vec3 scaled(A, B, f.c - A * ray_x - B * ray_y);  // n . p = 1
    const double norm = scaled.norm();
    const Vec3 normal = scaled / norm;
    const double cosine = normal.dot(ray) / ray.norm();
    if (cosine < config_.min_view_cosine || f.rms > config_.max_roughness * expected / std::sqrt(cosine))
      return std::nullopt;

    // the point is the mean nearby, so that a round surface does not lie too deep
    const int centre_u = std::min(kCentre, window.u), centre_v = std::min(kCentre, window.v);
    double sum = 0.0;
    int n = 0;
    for (int dv = -centre_v; dv <= centre_v; ++dv)
      for (int du = -centre_u; du <= centre_u; ++du) {
        const int u = u0 + du, v = v0 + dv;
        if (u < 0 || v < 0 || u >= k.width || v >= k.height || !(object_.values[at(u, v)] > 0)) continue;
        const double e = static_cast<double>(object_.values[at(u, v)]) - (f.a * du + f.b * dv);
        if (std::abs(e - f.c) > 5 * expected) continue;
        sum += e;
        ++n;
      }
    if (n < 4) return std::nullopt;

    Sample sample;
    sample.point = ray * (n / sum);
    sample.normal = normal;
    sample.sigma = std::hypot(noise_.sigma(z) * normal.dot(ray), config_.noise_floor_m);
    const double independent = std::max(1.0, f.n / config_.correlated_pixels);
    const double per_slope = std::max(f.rms, 0.5 * expected) * std::sqrt(3.0 / independent) / norm;
    sample.tilt =
        std::hypot(per_slope * k.fx / std::max(window.u, 1), per_slope * k.fy / std::max(window.v, 1)) /
        std::sqrt(2.0);
    if constexpr (kTerms == 6) sample.tilt *= config_.curved_tilt_factor;
    sample.bin = bin_of(normal);
    return sample;
  }

  [[nodiscard]] std::size_t at(int u, int v) const {
    return static_cast<std::size_t>(v) * static_cast<std::size_t>(reference_.cloud.width()) +
           static_cast<std::size_t>(u);
  }

  const ReferenceImage& reference_;
  const NoiseModel& noise_;
  const SurfaceSamplingConfig& config_;
  InverseDepth object_;
  WindowIntegrals integrals_;
};

// How many samples each bin gives: all of a small one, an equal part of the others.
std::size_t equal_part(std::vector<std::size_t> sizes, std::size_t count) {
  std::sort(sizes.begin(), sizes.end());
  std::size_t left = count;
  for (std::size_t i = 0; i < sizes.size(); ++i) {
    const std::size_t part = left / (sizes.size() - i);
    if (sizes[i] > part) return part;
    left -= sizes[i];
  }
  return sizes.empty() ? 0 : sizes.back();
}

}  // namespace

SurfaceSamples sample_surface(const ReferenceImage& reference, const Target& target, const NoiseModel& noise,
                              int count, const SurfaceSamplingConfig& config) {
  const ObjectPixels surface(reference, target, noise, config);
  const std::size_t stride =
      std::max<std::size_t>(1, target.pixels.size() / static_cast<std::size_t>(config.candidates));
  std::vector<std::vector<Sample>> bins(6 * kBinsPerSide * kBinsPerSide);
  for (std::size_t i = 0; i < target.pixels.size(); i += stride)
    if (const auto sample = surface.sample(target.pixels[i]))
      bins[static_cast<std::size_t>(sample->bin)].push_back(*sample);

  SurfaceSamples samples;
  const hal::Pose X_CW = reference.cloud.X_WC.inverse();
  std::size_t seen = 0;
  for (const std::uint32_t i : target.pixels) {
    if (!reference.cloud.seen(i)) continue;
    samples.middle += X_CW * reference.cloud.point(i);
    ++seen;
  }
  samples.middle /= static_cast<double>(std::max<std::size_t>(1, seen));

  std::vector<std::size_t> sizes;
  for (const auto& bin : bins) sizes.push_back(bin.size());
  const std::size_t part = equal_part(sizes, static_cast<std::size_t>(count));
  double squares = 0.0;
  for (const auto& bin : bins) {
    const std::size_t wanted = std::min(part, bin.size());
    for (std::size_t j = 0; j < wanted; ++j) {
      const Sample& s = bin[j * bin.size() / wanted];
      const auto put = [](std::vector<float>& to, double value) { to.push_back(static_cast<float>(value)); };
      put(samples.x, s.point.x()), put(samples.y, s.point.y()), put(samples.z, s.point.z());
      put(samples.nx, s.normal.x()), put(samples.ny, s.normal.y()), put(samples.nz, s.normal.z());
      put(samples.sigma_m, s.sigma), put(samples.tilt_rad, s.tilt);
      squares += (s.point - samples.middle).squaredNorm();
    }
  }
  if (samples.size() > 0) samples.radius_m = std::sqrt(squares / static_cast<double>(samples.size()));
  return samples;
}

}  // namespace colift::perception
