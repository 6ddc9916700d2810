#include "perception/reference_image.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "hal/types/avx2.hpp"

namespace colift::perception {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kFar = std::numeric_limits<float>::max();

using hal::ErrorCode;
using hal::failure;

hal::Result<> check(std::span<const hal::DepthFrame> frames) {
  if (frames.empty()) {
    return failure(ErrorCode::BadInput, "reference image",
                   "no frame was given; one is needed, 10 to 30 are better");
  }
  if (frames.size() > std::numeric_limits<std::uint16_t>::max()) {
    return failure(ErrorCode::BadInput, "reference image",
                   fmt::format("{} frames, at most 65535", frames.size()));
  }
  const auto& first = frames.front().intrinsics;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const auto& k = frames[i].intrinsics;
    if (k.width != first.width || k.height != first.height) {
      return failure(ErrorCode::BadInput, fmt::format("reference image: frame {}", i),
                     fmt::format("{} x {} pixels, the first frame has {} x {}", k.width, k.height,
                                 first.width, first.height));
    }
    if (k.width <= 0 || k.height <= 0 ||
        frames[i].depth_m.size() != static_cast<std::size_t>(k.width) * static_cast<std::size_t>(k.height)) {
      return failure(
          ErrorCode::BadInput, fmt::format("reference image: frame {}", i),
          fmt::format("{} depth values for {} x {} pixels", frames[i].depth_m.size(), k.width, k.height));
    }
  }
  return {};
}

// Running figures of one image row over all frames, in plain arrays.
struct RowSums {
  explicit RowSums(std::size_t width) : sum(width), squares(width), near(width), far(width), seen(width) {}
  std::vector<float> sum, squares, near, far, seen;

  void clear() {
    std::fill(sum.begin(), sum.end(), 0.0F);
    std::fill(squares.begin(), squares.end(), 0.0F);
    std::fill(near.begin(), near.end(), kFar);
    std::fill(far.begin(), far.end(), 0.0F);
    std::fill(seen.begin(), seen.end(), 0.0F);
  }
};

// The loops have no branch, so that they become SIMD code: a missing depth (NaN compares false) changes
// nothing.
COLIFT_ALSO_AVX2 void add_row(const float* __restrict depth, std::size_t n, float* __restrict sum,
                              float* __restrict seen, float* __restrict near, float* __restrict far) {
  for (std::size_t u = 0; u < n; ++u) {
    const float d = depth[u];
    const float known = d > 0.0F ? d : kFar, valid = known < kFar ? 1.0F : 0.0F;
    const float counted = known < kFar ? known : 0.0F;
    sum[u] += counted;
    seen[u] += valid;
    near[u] = known < near[u] ? known : near[u];
    far[u] = counted > far[u] ? counted : far[u];
  }
}

// second pass, about the mean: the difference of two large sums would drown a millimetre in float
COLIFT_ALSO_AVX2 void add_row_squares(const float* __restrict depth, const float* __restrict mean,
                                      std::size_t n, float* __restrict squares) {
  for (std::size_t u = 0; u < n; ++u) {
    const float d = depth[u], e = d - mean[u];
    const float known = d > 0.0F ? d : kFar, square = e * e;
    const float counted = known < kFar ? square : 0.0F;
    squares[u] += counted == counted ? counted : 0.0F;
  }
}

struct Typical {
  float mean, spread;
};

// Mean of the values within `gate` of the median: at an edge the frames see now the near side, now the far
// one, and their mean would be a surface where there is none.
Typical majority(std::vector<float>& values, float gate) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>((values.size() - 1) / 2);
  std::nth_element(values.begin(), middle, values.end());
  const float median = *middle;
  double sum = 0.0, squares = 0.0;
  int n = 0;
  for (const float d : values) {
    if (std::abs(d - median) > gate) continue;
    sum += d - median;
    squares += (d - median) * (d - median);
    ++n;
  }
  const double shift = sum / n;
  return {static_cast<float>(median + shift),
          static_cast<float>(std::sqrt(std::max(0.0, squares / n - shift * shift)))};
}

}  // namespace

hal::Result<ReferenceImage> build_reference(std::span<const hal::DepthFrame> frames, const hal::Pose& X_WC,
                                            const NoiseModel& noise, const ReferenceConfig& config) {
  if (auto ok = check(frames); !ok) return tl::unexpected(ok.error());

  const auto& k = frames.front().intrinsics;
  const auto width = static_cast<std::size_t>(k.width);
  const auto pixels = width * static_cast<std::size_t>(k.height);
  ReferenceImage reference;
  reference.frames = static_cast<int>(frames.size());
  reference.near_m.assign(pixels, kNan);
  reference.spread_m.assign(pixels, 0.0F);
  reference.count.assign(pixels, 0);
  hal::DepthFrame typical;
  typical.exposed_at = frames.back().exposed_at;
  typical.intrinsics = k;
  typical.depth_m.assign(pixels, kNan);

  RowSums row(width);
  const NoiseModel noise_model = noise;  // copies, which no write to an array can change
  const double restless_sigma = config.restless_sigma, restless_steps = config.restless_steps;
  std::vector<float> values;
  values.reserve(frames.size());
  std::size_t seen = 0, restless = 0;
  for (std::size_t at = 0; at < pixels; at += width) {
    row.clear();
    for (const auto& frame : frames)
      add_row(frame.depth_m.data() + at, width, row.sum.data(), row.seen.data(), row.near.data(),
              row.far.data());
    float* mean = typical.depth_m.data() + at;
    for (std::size_t u = 0; u < width; ++u) mean[u] = row.seen[u] > 0.0F ? row.sum[u] / row.seen[u] : kNan;
    if (frames.size() > 1) {
      for (const auto& frame : frames)
        add_row_squares(frame.depth_m.data() + at, mean, width, row.squares.data());
    }
    float* const near_m = reference.near_m.data() + at;
    float* const spread_m = reference.spread_m.data() + at;
    std::uint16_t* const count = reference.count.data() + at;
    const float *const row_seen = row.seen.data(), *const row_near = row.near.data(),
                       *const row_far = row.far.data(), *const row_squares = row.squares.data();
    for (std::size_t u = 0; u < width; ++u) {
      if (row_seen[u] == 0.0F) continue;
      ++seen;
      near_m[u] = row_near[u];
      count[u] = static_cast<std::uint16_t>(row_seen[u]);
      spread_m[u] = std::sqrt(row_squares[u] / row_seen[u]);
      const double z_m = row_near[u];
      const auto gate = static_cast<float>(restless_sigma * noise_model.sigma(z_m) +
                                           restless_steps * noise_model.step(z_m));
      if (row_far[u] - row_near[u] <= gate) continue;
      ++restless;
      values.clear();
      for (const auto& frame : frames) {
        const float d = frame.depth_m[at + u];
        if (d > 0.0F && d < kFar) values.push_back(d);
      }
      const Typical agreed = majority(values, 0.5F * gate);
      mean[u] = agreed.mean;
      spread_m[u] = agreed.spread;
    }
  }
  if (seen == 0) {
    return failure(
        ErrorCode::NotFound, "reference image",
        fmt::format("none of the {} pixels was seen in any of the {} frames", pixels, frames.size()));
  }
  reference.restless = static_cast<double>(restless) / static_cast<double>(seen);
  if (reference.restless > config.max_restless) {
    return failure(
        ErrorCode::NotFound, "reference image",
        fmt::format(
            "{:.0f} % of the pixels changed between the {} frames (at most {:.0f} %): something moved "
            "while the reference was taken",
            100.0 * reference.restless, frames.size(), 100.0 * config.max_restless));
  }
  reference.cloud = deproject(typical, X_WC);
  return reference;
}

}  // namespace colift::perception
