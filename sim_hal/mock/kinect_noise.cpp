#include "sim_hal/mock/kinect_noise.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "sim_hal/mock/hash_random.hpp"
#include "sim_hal/mock/kinect_code.hpp"

namespace colift::sim_hal {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

// measured on planes in single frames of real sensors: the total, quantisation included
constexpr double kSigma0_m = 0.0003, kSigma2_per_m = 0.0012;
constexpr double kBaseline_m = 0.075;
constexpr float kNearest_m = 0.5f, kFarthest_m = 9.0f;
// two shapes that meet closer than this are one surface to the correlation window
constexpr float kJump_m = 0.02f;
constexpr double kEdgeJitter_px = 0.9;
constexpr double kFlyingPart = 0.05;
constexpr double kSpeckPart = 0.0015;

enum Stream : std::uint64_t { kAxial, kJitterU, kJitterV, kGrow, kFly, kFlyMix, kPatch, kSpeck };

// quantiles of the standard normal distribution at the middle of 4096 equal steps of probability; ends at 3.7
// sigma
const std::array<float, 4096>& normal_quantiles() {
  static const auto table = [] {
    std::array<float, 4096> q{};
    double x = -3.7;
    for (std::size_t i = 0; i < q.size(); ++i) {
      const double p = (static_cast<double>(i) + 0.5) / static_cast<double>(q.size());
      // Newton from the quantile before; the density changes little from one to the next
      for (int step = 0; step < 8; ++step) {
        const double density = std::exp(-0.5 * x * x) / std::sqrt(2.0 * std::numbers::pi);
        x -= (0.5 * std::erfc(-x / std::numbers::sqrt2) - p) / density;
      }
      q[i] = static_cast<float>(x);
    }
    return q;
  }();
  return table;
}

float normal(std::uint64_t bits) {
  return normal_quantiles()[bits >> 52];
}

// theta^2 / (pi/2 - theta)^2 over the cosine, the growth of axial noise at grazing angles (Nguyen, Izadi,
// Lovell 2012)
const std::array<float, 257>& grazing_growth() {
  static const auto table = [] {
    std::array<float, 257> g{};
    for (std::size_t i = 0; i < g.size(); ++i) {
      const double theta = std::acos(std::max(static_cast<double>(i) / 256.0, 0.02));
      g[i] = static_cast<float>(std::pow(theta / (std::numbers::pi / 2 - theta), 2));
    }
    return g;
  }();
  return table;
}

class Measurement {
 public:
  Measurement(const Rendering& truth, const KinectNoise& noise, std::uint64_t seed)
      : truth_(truth),
        noise_(noise),
        seed_(seed),
        width_(truth.intrinsics.width),
        height_(truth.intrinsics.height),
        z_(truth.depth_m),
        source_(truth.depth_m.size()) {
    for (std::size_t i = 0; i < source_.size(); ++i) source_[i] = static_cast<std::int32_t>(i);
    find_edges();
  }

  std::vector<float> run() {
    if (noise_.lateral) wander_at_edges();
    const std::vector<float> seen = z_;  // what light comes back from; the next three only take values away
    if (noise_.flying_pixels) fly(seen);
    if (noise_.shadow) cast_shadow(seen);
    if (noise_.holes) punch_holes();
    if (noise_.axial) shake();
    if (noise_.quantisation)
      for (float& z : z_) z = kinect_depth_m(kinect_raw_code(z));
    return std::move(z_);
  }

 private:
  [[nodiscard]] std::uint64_t random(Stream stream, std::uint64_t index) const {
    return hash(seed_, stream, index);
  }
  [[nodiscard]] std::size_t at(int u, int v) const { return static_cast<std::size_t>(v * width_ + u); }

  // shapes are convex, so depth jumps only where the shape changes
  void find_edges() {
    const auto jumps = [&](std::size_t a, std::size_t b) {
      return truth_.shape[a] != truth_.shape[b] && !(std::abs(z_[a] - z_[b]) < kJump_m);
    };
    std::vector<std::uint8_t> is_edge(z_.size(), 0);
    for (int v = 0; v < height_; ++v)
      for (int u = 0; u < width_; ++u) {
        const std::size_t i = at(u, v);
        if (u + 1 < width_ && jumps(i, i + 1)) is_edge[i] = is_edge[i + 1] = 1;
        const std::size_t below = i + static_cast<std::size_t>(width_);
        if (v + 1 < height_ && jumps(i, below)) is_edge[i] = is_edge[below] = 1;
      }
    for (std::size_t i = 0; i < is_edge.size(); ++i)
      if (is_edge[i]) edge_.push_back(static_cast<std::int32_t>(i));
  }

  // Runs f(u, v, index) once for every pixel within `reach` of an edge, in image order.
  template <class F>
  void near_edges(int reach, F f) const {
    std::vector<std::uint8_t> near(z_.size(), 0);
    for (const std::int32_t i : edge_) {
      const int u = i % width_, v = i / width_;
      for (int y = std::max(v - reach, 0); y <= std::min(v + reach, height_ - 1); ++y)
        for (int x = std::max(u - reach, 0); x <= std::min(u + reach, width_ - 1); ++x) near[at(x, y)] = 1;
    }
    for (int v = 0; v < height_; ++v)
      for (int u = 0; u < width_; ++u)
        if (near[at(u, v)]) f(u, v, at(u, v));
  }

  // The correlation window makes the outline ragged in pieces of a few pixels and lets the nearer surface win
  // more often than not. Away from edges a wandering ray would only be axial noise, which has its own model.
  void wander_at_edges() {
    near_edges(2, [&](int u, int v, std::size_t i) {
      const auto piece = static_cast<std::uint64_t>(v / 2 * width_ + u / 2);
      const auto wander = [&](Stream s) {
        return static_cast<int>(std::lround(kEdgeJitter_px * normal(random(s, piece))));
      };
      const int du = wander(kJitterU), dv = wander(kJitterV);
      const std::size_t there = at(std::clamp(u + du, 0, width_ - 1), std::clamp(v + dv, 0, height_ - 1));
      take_from(i, there);
      if (random(kGrow, piece) >> 63) {
        const std::size_t opposite =
            at(std::clamp(u - du, 0, width_ - 1), std::clamp(v - dv, 0, height_ - 1));
        if (truth_.depth_m[opposite] < z_[i]) take_from(i, opposite);
      }
    });
  }

  void take_from(std::size_t i, std::size_t there) {
    if (truth_.shape[i] == truth_.shape[there]) return;
    if (std::abs(truth_.depth_m[there] - truth_.depth_m[i]) < kJump_m) return;
    z_[i] = truth_.depth_m[there];
    source_[i] = static_cast<std::int32_t>(there);
  }

  // a value that belongs to neither surface, where the window sees both
  void fly(const std::vector<float>& seen) {
    const auto threshold = static_cast<std::uint64_t>(kFlyingPart * 0x1p53);
    for (const std::int32_t edge : edge_) {
      const auto i = static_cast<std::size_t>(edge);
      if (random(kFly, i) >> 11 >= threshold) continue;
      const int u = edge % width_, v = edge / width_;
      float near = std::numeric_limits<float>::infinity(), far = 0.0f;
      for (int y = std::max(v - 1, 0); y <= std::min(v + 1, height_ - 1); ++y)
        for (int x = std::max(u - 1, 0); x <= std::min(u + 1, width_ - 1); ++x) {
          const float z = seen[at(x, y)];
          if (z < near) near = z;
          if (z > far) far = z;
        }
      if (!(near < far)) continue;
      const auto mix = static_cast<float>(0.1 + 0.8 * unit(random(kFlyMix, i)));
      z_[i] = 1.0f / (mix / near + (1.0f - mix) / far);  // the window averages disparity
    }
  }

  // The projector stands to the right of the camera: what it sees is found by projecting the image's own
  // surfaces into its columns, nearest first. Surfaces that the camera does not see cast no shadow here.
  void cast_shadow(const std::vector<float>& seen) {
    const auto shift = static_cast<float>(truth_.intrinsics.fx * kBaseline_m);
    const int margin = static_cast<int>(shift / 0.3f) + 2;
    std::vector<float> nearest(static_cast<std::size_t>(width_ + margin));
    std::vector<float> disparity(static_cast<std::size_t>(width_));
    for (int v = 0; v < height_; ++v) {
      std::fill(nearest.begin(), nearest.end(), 0.0f);
      const auto column = [&](int u) {
        return static_cast<float>(u + margin) - disparity[static_cast<std::size_t>(u)];
      };
      for (int u = 0; u < width_; ++u) {
        const float z = seen[at(u, v)];
        float& d = disparity[static_cast<std::size_t>(u)];
        d = z > 0.3f ? shift / z : 0.0f;  // also false for NaN
        if (d == 0.0f) continue;
        int first = static_cast<int>(column(u) + 0.5f), last = first;
        // a surface that the camera sees without a gap has none for the projector either
        const float before = u > 0 ? disparity[static_cast<std::size_t>(u - 1)] : 0.0f;
        if (before > 0.0f && std::abs(before - d) < 1.0f) {
          const int neighbour = static_cast<int>(column(u - 1) + 0.5f);
          first = std::min(first, neighbour + 1), last = std::max(last, neighbour - 1);
        }
        for (int c = std::max(first, 0); c <= last; ++c) {
          float& n = nearest[static_cast<std::size_t>(c)];
          n = std::max(n, d);
        }
      }
      for (int u = 0; u < width_; ++u) {
        const float d = disparity[static_cast<std::size_t>(u)];
        const int c = static_cast<int>(column(u) + 0.5f);
        if (d > 0.0f && c >= 0 && nearest[static_cast<std::size_t>(c)] > d + 1.0f) z_[at(u, v)] = kNan;
      }
    }
  }

  // smooth numbers in [0, 1) with lumps of about `cell` pixels
  [[nodiscard]] double lumps(int u, int v, int cell) const {
    const double x = static_cast<double>(u) / cell, y = static_cast<double>(v) / cell;
    const int i = static_cast<int>(x), j = static_cast<int>(y);
    const auto knot = [&](int a, int b) {
      return unit(random(kPatch, static_cast<std::uint64_t>(b * 4096 + a)));
    };
    const double s = x - i, t = y - j;
    return (1 - t) * ((1 - s) * knot(i, j) + s * knot(i + 1, j)) +
           t * ((1 - s) * knot(i, j + 1) + s * knot(i + 1, j + 1));
  }

  void punch_holes() {
    const auto speck = static_cast<std::uint64_t>(kSpeckPart / 1.5 * 0x1p53);
    const int last_columns = width_ / 80;  // 8 of 640: the correlation window does not fit there
    for (int v = 0; v < height_; ++v)
      for (int u = 0; u < width_; ++u) {
        const std::size_t i = at(u, v);
        const float z = z_[i];
        if (!(z >= kNearest_m && z <= kFarthest_m) || u >= width_ - last_columns) {
          z_[i] = kNan;
          continue;
        }
        const std::uint64_t bits = random(kSpeck, i);
        if (bits >> 11 < speck) {
          z_[i] = kNan;
          if (bits & 1 && u > 0) z_[i - 1] = kNan;
          continue;
        }
        if (too_dark(u, v, i)) z_[i] = kNan;
      }
  }

  // Light that comes back falls with the square of the distance and with the angle. The limits are chosen so
  // that grey floors are seen to about 4 m at 25 degrees and black plastics only when they face the camera,
  // as in recordings.
  [[nodiscard]] bool too_dark(int u, int v, std::size_t i) const {
    const auto source = static_cast<std::size_t>(source_[i]);
    const std::int16_t shape = truth_.shape[source];
    if (shape < 0) return false;
    const float cosine = truth_.cos_incidence[source];
    const float z = std::max(z_[i], 1.0f);
    const float light = truth_.reflectivity[static_cast<std::size_t>(shape)] * cosine / (z * z);
    if (light > 0.016f && cosine > 0.2f) return false;
    const double patch = lumps(u, v, 6);
    return light < 0.006 + 0.01 * patch * patch || cosine < 0.08 + 0.12 * patch * patch;
  }

  // Noise of neighbours is alike, since their correlation windows overlap: white noise, smoothed along rows
  // and across. In planes of real frames neighbours along a row correlate by 0.4 to 0.6, next but one by 0.2
  // to 0.35.
  void shake() {
    constexpr double kFit = 0.20412414523193154;  // 1 / sqrt(6 * 4): unit variance after 1 2 1 and 1 1 1 1
    const auto n = static_cast<std::size_t>(width_);
    std::vector<float> white[3];
    const auto fill = [&](int v, std::vector<float>& row) {
      row.resize(n + 3);
      for (std::size_t u = 0; u < row.size(); ++u)
        row[u] = normal(random(kAxial, static_cast<std::uint64_t>(v + 1) * 65536 + u));
    };
    for (int v = -1; v < 1; ++v) fill(v, white[v + 1]);
    std::vector<float> column(n + 3);
    for (int v = 0; v < height_; ++v) {
      fill(v + 1, white[(v + 2) % 3]);
      const std::vector<float>&above = white[v % 3], &here = white[(v + 1) % 3], &below = white[(v + 2) % 3];
      for (std::size_t u = 0; u < column.size(); ++u) column[u] = above[u] + 2.0f * here[u] + below[u];
      for (std::size_t u = 0; u < n; ++u) {
        const std::size_t i = at(0, v) + u;
        if (!(z_[i] > 0)) continue;
        const float g =
            (column[u] + column[u + 1] + column[u + 2] + column[u + 3]) * static_cast<float>(kFit);
        z_[i] += g * sigma(z_[i], truth_.cos_incidence[static_cast<std::size_t>(source_[i])]);
      }
    }
  }

  [[nodiscard]] float sigma(float z, float cosine) const {
    const float growth = grazing_growth()[static_cast<std::size_t>(cosine * 256.0f)];
    const float total = static_cast<float>(kSigma0_m) + static_cast<float>(kSigma2_per_m) * z * z +
                        0.0001f / std::sqrt(z) * growth;
    if (!noise_.quantisation) return total;
    // rounding to codes adds its own twelfth of a step squared; the sum is what was measured
    const auto step = static_cast<float>(kinect_step_m(z));
    return std::sqrt(std::max(total * total - step * step / 12.0f, 0.1f * total * total));
  }

  const Rendering& truth_;
  const KinectNoise& noise_;
  std::uint64_t seed_;
  int width_, height_;
  std::vector<float> z_;
  std::vector<std::int32_t> source_;  // pixel of the rendering that each measured value comes from
  std::vector<std::int32_t> edge_;    // pixels beside a depth jump
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
