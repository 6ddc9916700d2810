#include "sim_hal/synthetic/kinect/kinect_noise.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <span>

#include "sim_hal/synthetic/hash_random.hpp"
#include "sim_hal/synthetic/kinect/kinect_edges.hpp"
#include "sim_hal/synthetic/kinect/kinect_grain.hpp"
#include "sim_hal/synthetic/kinect/kinect_light.hpp"
#include "sim_hal/synthetic/kinect/kinect_rows.hpp"
#include "sim_hal/synthetic/kinect/kinect_shadow.hpp"
#include "sim_hal/synthetic/kinect/kinect_tables.hpp"

namespace colift::sim_hal {
namespace {

// two shapes that meet closer than this are one surface to the correlation window
constexpr float kJump_m = 0.02f;
constexpr double kFlyingPart = 0.05;

enum Stream : std::uint64_t { kWander = 16, kFly, kFlyMix };

// One image, row by row while a row is near at hand; which pixels see beside an edge is found out before.
class Measurement {
 public:
  Measurement(const Rendering& truth, const KinectNoise& noise, std::uint64_t seed)
      : truth_(truth),
        noise_(noise),
        seed_(seed),
        width_(truth.intrinsics.width),
        height_(truth.intrinsics.height),
        whole_((static_cast<std::size_t>(width_) + 3) / 4 * 4) {}

  std::vector<float> run() {
    std::optional<PixelSet> edges;
    if (noise_.lateral || noise_.flying_pixels) edges = find_edges(truth_, kJump_m);
    if (noise_.lateral) wander_at(*edges);
    return rows(noise_.flying_pixels ? &*edges : nullptr);
  }

 private:
  struct Moved {
    std::size_t pixel, source;
  };
  struct Flying {
    std::size_t column;
    float depth_m;
  };

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
      moved_[count] = {i, source};
      count += source != i;
    });
    moved_.resize(count);
  }

  [[nodiscard]] std::span<const Moved> moved_in(int v) const {
    const auto before = [](const Moved& m, std::size_t pixel) { return m.pixel < pixel; };
    const auto begin = std::lower_bound(moved_.begin(), moved_.end(), at(0, v), before);
    return {begin, std::lower_bound(begin, moved_.end(), at(0, v + 1), before)};
  }

  // true depth of what a pixel sees, which may be elsewhere
  [[nodiscard]] float depth_seen(std::span<const Moved> moved, std::size_t pixel) const {
    const auto m = std::lower_bound(moved.begin(), moved.end(), pixel,
                                    [](const Moved& a, std::size_t i) { return a.pixel < i; });
    return truth_.depth_m[m != moved.end() && m->pixel == pixel ? m->source : pixel];
  }

  // a row of the rendering itself, or a copy where pixels see elsewhere
  template <class T>
  const T* seen(const std::vector<T>& truth, std::size_t begin, std::span<const Moved> moved,
                std::vector<T>& copy) const {
    if (moved.empty() && whole_ == static_cast<std::size_t>(width_)) return &truth[begin];
    std::copy_n(&truth[begin], width_, copy.begin());
    for (const Moved& m : moved) copy[m.pixel - begin] = truth[m.source];
    return copy.data();
  }

  // a value that belongs to neither surface, where the window sees both: of a row and its neighbours
  void fly_at(const PixelSet& edges, int v) {
    flying_.clear();
    const auto threshold = static_cast<std::uint64_t>(kFlyingPart * 0x1p53);
    edges.for_each_in_row(v, [&](int u, int, std::size_t i) {
      if (random(kFly, i) >> 11 >= threshold) return;
      float near = std::numeric_limits<float>::infinity(), far = 0.0f;
      for (int y = std::max(v - 1, 0); y <= std::min(v + 1, height_ - 1); ++y) {
        const std::span<const Moved> moved = moved_in(y);
        for (int x = std::max(u - 1, 0); x <= std::min(u + 1, width_ - 1); ++x) {
          const float z = depth_seen(moved, at(x, y));
          if (z < near) near = z;
          if (z > far) far = z;
        }
      }
      if (!(near < far)) return;
      const auto mix = static_cast<float>(0.1 + 0.8 * unit(random(kFlyMix, i)));
      // the window averages disparity
      flying_.push_back({static_cast<std::size_t>(u), 1.0f / (mix / near + (1.0f - mix) / far)});
    });
  }

  // All that follows asks for inverse depth, which is linear in disparity and in the raw codes.
  std::vector<float> rows(const PixelSet* edges) {
    const auto n = static_cast<std::size_t>(width_);
    std::optional<ProjectorShadow> shadow;
    if (noise_.shadow) shadow.emplace(width_, truth_.intrinsics.fx);
    std::optional<KinectLight> light;
    if (noise_.holes) light.emplace(truth_.reflectivity, width_, seed_);
    std::optional<KinectGrain> grain;
    if (noise_.axial) grain.emplace(width_, seed_);
    std::vector<float> w(whole_), cosines(whole_, 1.0f);
    std::vector<std::int16_t> shapes(whole_, -1);
    std::vector<float> image(truth_.depth_m.size());
    for (int v = 0; v < height_; ++v) {
      const std::size_t begin = at(0, v);
      const std::span<const Moved> moved = moved_in(v);
      const float* cosine = seen(truth_.cos_incidence, begin, moved, cosines);
      const std::int16_t* shape = seen(truth_.shape, begin, moved, shapes);
      kinect_rows::invert(&truth_.depth_m[begin], n, w.data());
      for (const Moved& m : moved) w[m.pixel - begin] = 1.0f / truth_.depth_m[m.source];
      std::fill(w.begin() + width_, w.end(), 1.0f);
      // both ask what light comes back from, before either has changed it
      if (shadow) shadow->find(w.data());
      if (edges) fly_at(*edges, v);
      for (const Flying& f : flying_) w[f.column] = 1.0f / f.depth_m;
      if (shadow) shadow->apply(w.data());
      if (light) light->punch_holes(v, shape, cosine, w.data());
      if (grain)
        kinect_rows::shake(grain->next_row(), KinectGrain::kUnit, cosine, noise_.quantisation, whole_,
                           w.data());
      read_out(v, moved, w.data(), &image[begin]);
    }
    return image;
  }

  // a row's depth as the sensor says it
  void read_out(int v, std::span<const Moved> moved, const float* inverse_depth, float* depth_m) const {
    const auto n = static_cast<std::size_t>(width_);
    if (noise_.quantisation) return kinect_rows::read_codes(inverse_depth, n, depth_m);
    if (noise_.axial) return kinect_rows::invert(inverse_depth, n, depth_m);
    std::copy_n(&truth_.depth_m[at(0, v)], n, depth_m);
    for (const Moved& m : moved) depth_m[m.pixel - at(0, v)] = truth_.depth_m[m.source];
    for (const Flying& f : flying_) depth_m[f.column] = f.depth_m;
    for (std::size_t u = 0; u < n; ++u)
      if (std::isnan(inverse_depth[u])) depth_m[u] = std::numeric_limits<float>::quiet_NaN();
  }

  const Rendering& truth_;
  const KinectNoise& noise_;
  std::uint64_t seed_;
  int width_, height_;
  std::size_t whole_;           // width, rounded up
  std::vector<Moved> moved_;    // in image order
  std::vector<Flying> flying_;  // of the row at hand
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
