#include "sim_hal/mock/kinect_noise.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>

#include "sim_hal/mock/float4.hpp"
#include "sim_hal/mock/hash_random.hpp"
#include "sim_hal/mock/kinect_code.hpp"
#include "sim_hal/mock/kinect_shadow.hpp"
#include "sim_hal/mock/kinect_tables.hpp"

namespace colift::sim_hal {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

// measured on planes in single frames of real sensors: the total, quantisation included
constexpr double kSigma0_m = 0.0003, kSigma2_per_m = 0.0012;
constexpr float kNearest_m = 0.5f, kFarthest_m = 9.0f;
// two shapes that meet closer than this are one surface to the correlation window
constexpr float kJump_m = 0.02f;
constexpr double kFlyingPart = 0.05;
constexpr double kSpeckPart = 0.0015;

enum Stream : std::uint64_t { kAxial, kJitterU, kJitterV, kGrow, kFly, kFlyMix, kPatch, kSpeck };

float normal(std::uint64_t bits) {
  return normal_quantiles()[bits >> 52];
}

// f(i) for every byte of an image that is not 0, in image order
template <class F>
void for_each_set(const std::vector<std::uint8_t>& flags, F f) {
  std::size_t i = 0;
  for (; i + 8 <= flags.size(); i += 8) {
    std::uint64_t eight = 0;
    std::memcpy(&eight, &flags[i], 8);
    if (eight == 0) continue;
    for (std::size_t k = i; k < i + 8; ++k)
      if (flags[k]) f(k);
  }
  for (; i < flags.size(); ++i)
    if (flags[i]) f(i);
}

class Measurement {
 public:
  Measurement(const Rendering& truth, const KinectNoise& noise, std::uint64_t seed)
      : truth_(truth),
        noise_(noise),
        seed_(seed),
        width_(truth.intrinsics.width),
        height_(truth.intrinsics.height),
        z_(truth.depth_m) {
    find_edges();
  }

  std::vector<float> run() {
    if (noise_.lateral) wander_at_edges();
    // both ask what light comes back from, before either has changed it
    if (noise_.flying_pixels) fly();
    if (noise_.shadow) {
      cast_shadow();
    } else {
      for (const Flying& f : flying_) z_[f.pixel] = f.depth_m;
    }
    if (noise_.holes) punch_holes();
    if (noise_.axial) shake();
    if (noise_.quantisation) quantise();
    return std::move(z_);
  }

 private:
  [[nodiscard]] std::uint64_t random(Stream stream, std::uint64_t index) const {
    return hash(seed_, stream, index);
  }
  [[nodiscard]] std::size_t at(int u, int v) const { return static_cast<std::size_t>(v * width_ + u); }

  // shapes are convex, so depth jumps only where the shape changes
  void find_edges() {
    const std::int16_t* shape = truth_.shape.data();
    std::vector<std::uint8_t> is_edge(z_.size(), 0);
    const auto check = [&](std::size_t a, std::size_t b) {
      if (shape[a] != shape[b] && !(std::abs(z_[a] - z_[b]) < kJump_m)) is_edge[a] = is_edge[b] = 1;
    };
    // four pixels and the four beside or below them at once: nearly everywhere they are alike
    const auto alike = [&](std::size_t a, std::size_t b) {
      return std::memcmp(shape + a, shape + b, 4 * sizeof *shape) == 0;
    };
    const auto row = static_cast<std::size_t>(width_);
    for (int v = 0; v < height_; ++v) {
      const bool last_row = v + 1 == height_;
      for (int u = 0; u < width_; u += 4) {
        const std::size_t begin = at(u, v);
        if (u + 4 < width_ && alike(begin, begin + 1) && (last_row || alike(begin, begin + row))) continue;
        for (int k = u; k < std::min(u + 4, width_); ++k) {
          const std::size_t i = at(k, v);
          if (k + 1 < width_) check(i, i + 1);
          if (!last_row) check(i, i + row);
        }
      }
    }
    for_each_set(is_edge, [&](std::size_t i) { edges_.push_back(static_cast<std::int32_t>(i)); });
  }

  // Runs f(u, v, index) once for every pixel within `reach` of an edge, in image order.
  template <class F>
  void near_edges(int reach, F f) const {
    std::vector<std::uint8_t> near(z_.size(), 0);
    for (const std::int32_t i : edges_) {
      const int u = i % width_, v = i / width_;
      const int from = std::max(u - reach, 0), to = std::min(u + reach, width_ - 1);
      for (int y = std::max(v - reach, 0); y <= std::min(v + reach, height_ - 1); ++y)
        for (int x = from; x <= to; ++x) near[at(x, y)] = 1;
    }
    for_each_set(near, [&](std::size_t i) {
      const auto pixel = static_cast<std::int32_t>(i);
      f(pixel % width_, pixel / width_, i);
    });
  }

  // The correlation window makes the outline ragged in pieces of a few pixels and lets the nearer surface win
  // more often than not. Away from edges a wandering ray would only be axial noise, which has its own model.
  void wander_at_edges() {
    const auto wander = [&](Stream s, std::uint64_t piece) {
      return static_cast<int>(wander_steps()[random(s, piece) >> 52]);
    };
    std::uint64_t last_piece = ~std::uint64_t{0};
    int du = 0, dv = 0;
    bool grows = false;
    near_edges(2, [&](int u, int v, std::size_t i) {
      const auto piece = static_cast<std::uint64_t>(v / 2 * width_ + u / 2);
      if (piece != last_piece) {
        du = wander(kJitterU, piece), dv = wander(kJitterV, piece);
        grows = random(kGrow, piece) >> 63;
        last_piece = piece;
      }
      const std::size_t there = at(std::clamp(u + du, 0, width_ - 1), std::clamp(v + dv, 0, height_ - 1));
      take_from(i, there);
      if (!grows) return;
      const std::size_t opposite = at(std::clamp(u - du, 0, width_ - 1), std::clamp(v - dv, 0, height_ - 1));
      if (truth_.depth_m[opposite] < z_[i]) take_from(i, opposite);
    });
  }

  void take_from(std::size_t i, std::size_t there) {
    if (truth_.shape[i] == truth_.shape[there]) return;
    if (std::abs(truth_.depth_m[there] - truth_.depth_m[i]) < kJump_m) return;
    z_[i] = truth_.depth_m[there];
    moved_.push_back({i, there});
  }

  // Runs f(u, source) for every pixel of a row whose value comes from elsewhere; call it row by row, with the
  // same `next`, that begins at 0.
  template <class F>
  void for_each_moved(int v, std::size_t& next, F f) const {
    const std::size_t begin = at(0, v), end = at(0, v + 1);
    for (; next < moved_.size() && moved_[next].pixel < end; ++next)
      f(moved_[next].pixel - begin, moved_[next].source);
  }

  // a value that belongs to neither surface, where the window sees both
  void fly() {
    const auto threshold = static_cast<std::uint64_t>(kFlyingPart * 0x1p53);
    for (const std::int32_t edge : edges_) {
      const auto i = static_cast<std::size_t>(edge);
      if (random(kFly, i) >> 11 >= threshold) continue;
      const int u = edge % width_, v = edge / width_;
      float near = std::numeric_limits<float>::infinity(), far = 0.0f;
      for (int y = std::max(v - 1, 0); y <= std::min(v + 1, height_ - 1); ++y)
        for (int x = std::max(u - 1, 0); x <= std::min(u + 1, width_ - 1); ++x) {
          const float z = z_[at(x, y)];
          if (z < near) near = z;
          if (z > far) far = z;
        }
      if (!(near < far)) continue;
      const auto mix = static_cast<float>(0.1 + 0.8 * unit(random(kFlyMix, i)));
      flying_.push_back({i, 1.0f / (mix / near + (1.0f - mix) / far)});  // the window averages disparity
    }
  }

  void cast_shadow() {
    ProjectorShadow shadow(width_, truth_.intrinsics.fx);
    auto flying = flying_.begin();
    for (int v = 0; v < height_; ++v) {
      float* row = &z_[at(0, v)];
      shadow.find(row);
      for (; flying != flying_.end() && flying->pixel < at(0, v + 1); ++flying)
        z_[flying->pixel] = flying->depth_m;
      shadow.apply(row);
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
    const auto n = static_cast<std::size_t>(width_);
    // the last 8 of 640 columns: the correlation window does not fit there
    const std::size_t seen_columns = n - n / 80;
    std::vector<float> sent_back(n), cosine(n);
    std::vector<std::uint8_t> speck(n);
    std::vector<float> reflectivity(truth_.reflectivity);
    reflectivity.insert(reflectivity.begin(), std::numeric_limits<float>::infinity());  // of no shape
    const auto light_of = [&](std::size_t pixel, std::size_t u) {
      const std::int16_t shape = truth_.shape[pixel];
      cosine[u] = shape < 0 ? 1.0f : truth_.cos_incidence[pixel];
      sent_back[u] = reflectivity[static_cast<std::size_t>(shape + 1)] * cosine[u];
    };
    std::size_t next_moved = 0;
    for (int v = 0; v < height_; ++v) {
      const std::size_t begin = at(0, v);
      for (std::size_t u = 0; u < n; ++u) light_of(begin + u, u);
      for_each_moved(v, next_moved, [&](std::size_t u, std::size_t source) { light_of(source, u); });
      for (std::size_t u = 0; u < n; ++u) speck[u] = speck_at(begin + u);
      std::size_t u = 0;
      for (; u + 4 <= seen_columns; u += 4) {
        std::uint32_t specks = 0;
        std::memcpy(&specks, &speck[u], 4);
        if (specks == 0 && well_lit(&z_[begin + u], &sent_back[u], &cosine[u])) continue;
        for (std::size_t k = u; k < u + 4; ++k) punch(v, k, speck[k], sent_back[k], cosine[k]);
      }
      for (; u < seen_columns; ++u) punch(v, u, speck[u], sent_back[u], cosine[u]);
      std::fill(&z_[begin] + seen_columns, &z_[begin] + n, kNan);
    }
  }

  // 0: none, 1: here, 2: here and to the left
  [[nodiscard]] std::uint8_t speck_at(std::size_t i) const {
    constexpr auto kPart = static_cast<std::uint64_t>(kSpeckPart / 1.5 * 0x1p53);
    const std::uint64_t bits = random(kSpeck, i);
    return bits >> 11 < kPart ? static_cast<std::uint8_t>(1 + (bits & 1)) : std::uint8_t{0};
  }

  // true where four neighbours are in range and so bright that no other check is needed
  static bool well_lit(const float* depth_m, const float* sent_back, const float* cosine) {
    static const float kAbove = std::nextafter(kNearest_m, 0.0f), kBelow = std::nextafter(kFarthest_m, 10.0f);
    const Float4 z = Float4::load(depth_m), far = max(z, Float4(1.0f));
    const Float4 in_range = both(greater(z, Float4(kAbove)), greater(Float4(kBelow), z));
    const Float4 bright = both(greater(Float4::load(sent_back), Float4(0.01601f) * far * far),
                               greater(Float4::load(cosine), Float4(0.2f)));
    return all(both(in_range, bright));
  }

  void punch(int v, std::size_t u, std::uint8_t speck, float sent_back, float cosine) {
    float& z = z_[at(0, v) + u];
    if (!(z >= kNearest_m && z <= kFarthest_m)) {
      z = kNan;
    } else if (speck > 0) {
      z = kNan;
      if (speck > 1 && u > 0) z_[at(0, v) + u - 1] = kNan;
    } else if (too_dark(static_cast<int>(u), v, z, sent_back, cosine)) {
      z = kNan;
    }
  }

  // Light that comes back falls with the square of the distance and with the angle. The limits are chosen so
  // that grey floors are seen to about 4 m at 25 degrees and black plastics only when they face the camera,
  // as in recordings.
  [[nodiscard]] bool too_dark(int u, int v, float depth_m, float sent_back, float cosine) const {
    const float z = std::max(depth_m, 1.0f);
    const float light = sent_back / (z * z);
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
    const std::size_t whole = (n + 3) / 4 * 4;
    std::vector<float> white[3];
    const auto fill = [&](int v, std::vector<float>& row) {
      row.resize(n + 3);
      for (std::size_t u = 0; u < row.size(); ++u)
        row[u] = normal(random(kAxial, static_cast<std::uint64_t>(v + 1) * 65536 + u));
    };
    for (int v = -1; v < 1; ++v) fill(v, white[v + 1]);
    std::vector<float> column(n + 3), shift(whole), growth(whole), z(whole);
    const std::array<float, 257>& grazing = grazing_growth();
    const auto growth_at = [&](std::size_t pixel) {
      return grazing[static_cast<std::size_t>(truth_.cos_incidence[pixel] * 256.0f)];
    };
    std::size_t next_moved = 0;
    for (int v = 0; v < height_; ++v) {
      fill(v + 1, white[(v + 2) % 3]);
      const std::vector<float>&above = white[v % 3], &here = white[(v + 1) % 3], &below = white[(v + 2) % 3];
      for (std::size_t u = 0; u < column.size(); ++u) column[u] = above[u] + 2.0f * here[u] + below[u];
      for (std::size_t u = 0; u < n; ++u)
        shift[u] = (column[u] + column[u + 1] + column[u + 2] + column[u + 3]) * static_cast<float>(kFit);
      const std::size_t begin = at(0, v);
      for (std::size_t u = 0; u < n; ++u) growth[u] = growth_at(begin + u);
      for_each_moved(v, next_moved,
                     [&](std::size_t u, std::size_t source) { growth[u] = growth_at(source); });
      std::copy_n(&z_[begin], n, z.begin());
      shake_row(shift, growth, z);
      std::copy_n(z.begin(), n, &z_[begin]);
    }
  }

  // z += shift * sigma(z, growth), but for what has no depth
  void shake_row(const std::vector<float>& shift, const std::vector<float>& growth,
                 std::vector<float>& z) const {
    const Float4 sigma0(static_cast<float>(kSigma0_m)), sigma2(static_cast<float>(kSigma2_per_m));
    const Float4 side(0.0001f), twelfth(12.0f), least(0.1f), zero(0.0f);
    for (std::size_t u = 0; u < z.size(); u += 4) {
      const Float4 depth = Float4::load(&z[u]);
      Float4 sigma = sigma0 + sigma2 * depth * depth + side / sqrt(depth) * Float4::load(&growth[u]);
      if (noise_.quantisation) {
        // rounding to codes adds its own twelfth of a step squared; the sum is what was measured
        float steps[4];
        for (std::size_t k = 0; k < 4; ++k) steps[k] = static_cast<float>(kinect_step_m(z[u + k]));
        const Float4 step = Float4::load(steps);
        sigma = sqrt(max(sigma * sigma - step * step / twelfth, least * sigma * sigma));
      }
      const Float4 shaken = depth + Float4::load(&shift[u]) * sigma;
      select(greater(depth, zero), shaken, depth).store(&z[u]);
    }
  }

  void quantise() {
    for (float& z : z_) z = kinect_depth_m(kinect_raw_code(z));
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
  std::vector<std::int32_t> edges_;  // pixels beside a depth jump
  std::vector<Moved> moved_;         // in image order; of two for one pixel the later one counts
  std::vector<Flying> flying_;       // in image order
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
