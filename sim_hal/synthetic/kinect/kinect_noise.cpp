#include "sim_hal/synthetic/kinect/kinect_noise.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "sim_hal/synthetic/float4.hpp"
#include "sim_hal/synthetic/hash_random.hpp"
#include "sim_hal/synthetic/kinect/kinect_code.hpp"
#include "sim_hal/synthetic/kinect/kinect_edges.hpp"
#include "sim_hal/synthetic/kinect/kinect_grain.hpp"
#include "sim_hal/synthetic/kinect/kinect_light.hpp"
#include "sim_hal/synthetic/kinect/kinect_shadow.hpp"
#include "sim_hal/synthetic/kinect/kinect_tables.hpp"

namespace colift::sim_hal {
namespace {

// measured on planes in single frames of real sensors: the total, quantisation included
constexpr float kSigma0_m = 0.0003f, kSigma2_per_m = 0.0012f;
// two shapes that meet closer than this are one surface to the correlation window
constexpr float kJump_m = 0.02f;
constexpr double kFlyingPart = 0.05;
constexpr auto kCode_m = static_cast<float>(kKinectK_mm / 1000.0);  // k in raw = raw at infinity - k / z

// theta^2 / (pi/2 - theta)^2 times 0.1 mm sqrt(m) / sqrt(z), the growth of axial noise at grazing angles
// (Nguyen, Izadi, Lovell 2012), without its last factor. The parabola is a fit of cos^2 / (1 - cos) theta^2 /
// (pi/2 - theta)^2, good to 1.3 % beyond 32 degrees; before, to 0.7 um.
Float4 grazing_sigma(Float4 cosine) {
  const Float4 c = max(cosine, Float4(0.02f)), one(1.0f);
  const Float4 fit = Float4(2.4604e-4f) - (Float4(0.5635e-4f) + Float4(0.7301e-4f) * c) * c;
  return (one - c) * fit / (c * c);
}

enum Stream : std::uint64_t { kWander = 16, kFly, kFlyMix };

// One image, done in two steps: what happens along edges, then everything else row by row, while a row is
// near at hand.
class Measurement {
 public:
  Measurement(const Rendering& truth, const KinectNoise& noise, std::uint64_t seed)
      : truth_(truth),
        noise_(noise),
        seed_(seed),
        width_(truth.intrinsics.width),
        height_(truth.intrinsics.height),
        z_(truth.depth_m) {}

  std::vector<float> run() {
    if (noise_.lateral || noise_.flying_pixels) {
      const PixelSet edges = find_edges(truth_, kJump_m);
      if (noise_.lateral) wander_at(edges);
      if (noise_.flying_pixels) fly_at(edges);
    }
    rows();
    return std::move(z_);
  }

 private:
  [[nodiscard]] std::uint64_t random(Stream stream, std::uint64_t index) const {
    return hash(seed_, stream, index);
  }
  [[nodiscard]] std::size_t at(int u, int v) const { return static_cast<std::size_t>(v * width_ + u); }

  [[nodiscard]] std::size_t clamped(int u, int v) const {
    return at(std::clamp(u, 0, width_ - 1), std::clamp(v, 0, height_ - 1));
  }
  [[nodiscard]] bool at_border(int u, int v) const {
    return u < kMostSteps || v < kMostSteps || u >= width_ - kMostSteps || v >= height_ - kMostSteps;
  }

  // The correlation window makes the outline ragged in pieces of a few pixels and lets the nearer surface win
  // more often than not. Away from edges a wandering ray would only be axial noise, which has its own model.
  void wander_at(const PixelSet& edges) {
    const PixelSet near = edges.grown(2);
    moved_.resize(near.count());
    std::size_t count = 0;
    const float* z = truth_.depth_m.data();
    const std::int16_t* shape = truth_.shape.data();
    const std::array<std::int8_t, 4096>& steps = wander_steps();
    const auto other_surface = [&](std::size_t a, std::size_t b) {
      const bool near_by = std::abs(z[a] - z[b]) < kJump_m;
      return static_cast<std::size_t>((shape[a] != shape[b]) & !near_by);
    };
    // whether a pixel changes is a toss-up, so nothing but the image's border is a branch
    near.for_each([&](int u, int v, std::size_t i) {
      const std::uint64_t bits = random(kWander, static_cast<std::uint64_t>(v / 2 * width_ + u / 2));
      const int du = steps[bits >> 52], dv = steps[bits >> 40 & 0xfff];
      const auto by = static_cast<std::size_t>(static_cast<std::ptrdiff_t>(dv) * width_ + du);
      std::size_t there = i + by, opposite = i - by;
      if (at_border(u, v)) there = clamped(u + du, v + dv), opposite = clamped(u - du, v - dv);
      std::size_t source = i + (there - i) * other_surface(i, there);
      const std::size_t grows = bits & 1, nearer = z[opposite] < z[source];
      source += (opposite - source) * (grows & nearer & other_surface(i, opposite));
      z_[i] = z[source];
      moved_[count] = {i, source};
      count += source != i;
    });
    moved_.resize(count);
  }

  // a value that belongs to neither surface, where the window sees both
  void fly_at(const PixelSet& edges) {
    const auto threshold = static_cast<std::uint64_t>(kFlyingPart * 0x1p53);
    edges.for_each([&](int u, int v, std::size_t i) {
      if (random(kFly, i) >> 11 >= threshold) return;
      float near = std::numeric_limits<float>::infinity(), far = 0.0f;
      for (int y = std::max(v - 1, 0); y <= std::min(v + 1, height_ - 1); ++y)
        for (int x = std::max(u - 1, 0); x <= std::min(u + 1, width_ - 1); ++x) {
          const float z = z_[at(x, y)];
          if (z < near) near = z;
          if (z > far) far = z;
        }
      if (!(near < far)) return;
      const auto mix = static_cast<float>(0.1 + 0.8 * unit(random(kFlyMix, i)));
      flying_.push_back({i, 1.0f / (mix / near + (1.0f - mix) / far)});  // the window averages disparity
    });
  }

  // All that follows asks for inverse depth, which is linear in disparity and in the raw codes.
  void rows() {
    const auto n = static_cast<std::size_t>(width_), whole = (n + 3) / 4 * 4;
    std::optional<ProjectorShadow> shadow;
    if (noise_.shadow) shadow.emplace(width_, truth_.intrinsics.fx);
    std::optional<KinectLight> light;
    if (noise_.holes) light.emplace(truth_.reflectivity, width_, seed_);
    std::optional<KinectGrain> grain;
    if (noise_.axial) grain.emplace(width_, seed_);
    // of one row, with what its pixels took from elsewhere
    std::vector<float> z(whole, 1.0f), w(whole), cosine(whole, 1.0f);
    std::vector<std::int16_t> shape(whole, -1);
    auto flying = flying_.begin();
    auto moved = moved_.begin();
    for (int v = 0; v < height_; ++v) {
      const std::size_t begin = at(0, v), end = at(0, v + 1);
      std::copy_n(&z_[begin], n, z.begin());
      std::copy_n(&truth_.cos_incidence[begin], n, cosine.begin());
      std::copy_n(&truth_.shape[begin], n, shape.begin());
      for (; moved != moved_.end() && moved->pixel < end; ++moved) {
        cosine[moved->pixel - begin] = truth_.cos_incidence[moved->source];
        shape[moved->pixel - begin] = truth_.shape[moved->source];
      }
      invert(z.data(), w.data(), whole);
      // both ask what light comes back from, before either has changed it
      if (shadow) shadow->find(w.data());
      for (; flying != flying_.end() && flying->pixel < end; ++flying) {
        z[flying->pixel - begin] = flying->depth_m;
        w[flying->pixel - begin] = 1.0f / flying->depth_m;
      }
      if (shadow) shadow->apply(w.data());
      if (light) light->punch_holes(v, shape.data(), cosine.data(), w.data());
      if (grain) shake(grain->next_row(), cosine.data(), w.data(), whole);
      if (noise_.quantisation) {
        from_nearest_codes(w.data(), z.data(), whole);
      } else if (noise_.axial) {
        invert(w.data(), z.data(), whole);
      } else {
        keep_known(w.data(), z.data(), whole);
      }
      std::copy_n(z.begin(), n, &z_[begin]);
    }
  }

  static void invert(const float* from, float* to, std::size_t n) {
    for (std::size_t u = 0; u < n; u += 4) (Float4(1.0f) / Float4::load(from + u)).store(to + u);
  }

  // w += grain * sigma, but for what has no depth
  void shake(const std::int16_t* grain, const float* cosine, float* inverse_depth, std::size_t n) const {
    // a depth error e at z is one of e / z^2 of 1 / z; rounding to codes adds its own twelfth of a step
    // squared, and the sum is what was measured
    const Float4 sigma0(kSigma0_m), sigma2(kSigma2_per_m), grain_unit(KinectGrain::kUnit);
    const Float4 rounding2(noise_.quantisation ? 1.0f / (12.0f * kCode_m * kCode_m) : 0.0f);
    for (std::size_t u = 0; u < n; u += 4) {
      const Float4 w = Float4::load(inverse_depth + u), side = grazing_sigma(Float4::load(cosine + u));
      const Float4 sigma = (sigma0 + side * rough_sqrt(w)) * w * w + sigma2;
      const Float4 own = rough_sqrt(sigma * sigma - rounding2);
      (w + Float4::load(grain + u) * grain_unit * own).store(inverse_depth + u);
    }
  }

  static void from_nearest_codes(const float* inverse_depth, float* depth_m, std::size_t n) {
    const float* table = kinect_depths_m().data();
    const Float4 first(0.0f), last(static_cast<float>(kKinectCodes + 1)), k(kCode_m);
    const Float4 at_infinity(static_cast<float>(kKinectRawAtInfinity + 1.5));  // a half to round, one up
    for (std::size_t u = 0; u < n; u += 4) {
      const Float4 raw = at_infinity - k * Float4::load(inverse_depth + u);
      std::uint32_t code[4];
      truncate(min(max(raw, first), last), code);  // the first for what has no depth
      gather(table, code).store(depth_m + u);
    }
  }

  static void keep_known(const float* inverse_depth, float* depth_m, std::size_t n) {
    const Float4 nothing(std::numeric_limits<float>::quiet_NaN());
    for (std::size_t u = 0; u < n; u += 4) {
      const Float4 w = Float4::load(inverse_depth + u);
      select(equal(w, w), Float4::load(depth_m + u), nothing).store(depth_m + u);
    }
  }

  struct Moved {
    std::size_t pixel, source;
  };
  struct Flying {
    std::size_t pixel;
    float depth_m;
  };

  const Rendering& truth_;
  const KinectNoise& noise_;
  std::uint64_t seed_;
  int width_, height_;
  std::vector<float> z_;
  std::vector<Moved> moved_;    // in image order
  std::vector<Flying> flying_;  // in image order
};

hal::DepthFrame frame_of(const Rendering& truth, std::vector<float> depth_m) {
  hal::DepthFrame frame;
  frame.intrinsics = truth.intrinsics;
  frame.depth_m = std::move(depth_m);
  frame.up_C = truth.X_WC.linear().transpose() * Vec3::UnitZ();
  return frame;
}

}  // namespace

hal::DepthFrame measure(const Rendering& truth, const KinectNoise& noise, std::uint64_t seed) {
  return frame_of(truth, Measurement(truth, noise, seed).run());
}

hal::DepthFrame measure_ideal(const Rendering& truth) {
  return frame_of(truth, truth.depth_m);
}

}  // namespace colift::sim_hal
