#include "sim_hal/synthetic/kinect/kinect_shadow.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "sim_hal/synthetic/float4.hpp"
#include "sim_hal/synthetic/kinect/kinect_rows.hpp"

namespace colift::sim_hal {
namespace {

constexpr double kBaseline_m = 0.075;
constexpr float kNearest_m = 0.3f;  // nothing nearer is seen, which bounds the disparity
// A row along which disparity rises by less per pixel has no shadow: then columns of the projector follow
// each other in the order of the camera's, and at most four neighbours share one.
constexpr float kSmooth_px = 0.15f;
constexpr std::size_t kAround_px = 4;

}  // namespace

ProjectorShadow::ProjectorShadow(int width, double fx)
    : width_(static_cast<std::size_t>(width)),
      shift_(static_cast<float>(fx * kBaseline_m)),
      margin_(static_cast<int>(shift_ / kNearest_m) + 2),
      columns_((width_ + 3) / 4 * 4),
      disparity_(columns_.size() + 4),
      nearest_(width_ + static_cast<std::size_t>(margin_)),
      column_(columns_.size()) {
  for (std::size_t u = 0; u < columns_.size(); ++u) columns_[u] = static_cast<float>(u);
}

void ProjectorShadow::find(const float* inverse_depth) {
  spans_.clear();
  if (width_ == 0) return;
  look(inverse_depth);
  find_jumps();
  if (jumps_.empty()) return;
  find_spans();
  std::fill(nearest_.begin(), nearest_.end(), 0.0f);
  for (const auto& [begin, end] : spans_) project(begin, end);
}

// disparities, 0 where there is no depth, and their range
void ProjectorShadow::look(const float* inverse_depth) {
  const std::size_t whole = columns_.size();
  kinect_rows::disparities(inverse_depth, columns_.data(), shift_, 1.0f / kNearest_m,
                           static_cast<float>(margin_) + 0.5f, whole, disparity_.data(), column_.data());
  const Float4 zero(0.0f), nothing(1e9f);
  Float4 low = nothing, high = zero;
  for (std::size_t u = 0; u < whole; u += 4) {
    const Float4 d = Float4::load(&disparity_[u]);
    low = min(low, select(greater(d, zero), d, nothing));
    high = max(high, d);
  }
  float lows[4], highs[4];
  low.store(lows), high.store(highs);
  low_ = *std::min_element(lows, lows + 4);
  high_ = *std::max_element(highs, highs + 4);
}

// Only where disparity rises to the right do columns of the projector come back; where it falls there is a
// gap, lit by the projector and not seen by the camera. Where there is no depth, both are possible.
void ProjectorShadow::find_jumps() {
  jumps_.clear();
  const Float4 smooth(kSmooth_px);
  const float* disparity = disparity_.data();
  for (std::size_t u = 0; u + 1 < width_; u += 4) {
    const Float4 rise = Float4::load(disparity + u + 1) - Float4::load(disparity + u);
    for (unsigned left = lanes(greater(rise, smooth)); left != 0; left &= left - 1) {
      const std::size_t k = u + static_cast<std::size_t>(std::countr_zero(left));
      if (k + 1 < width_) jumps_.push_back({k, std::min(disparity[k + 1] - disparity[k], high_ - low_)});
    }
  }
}

// What hides a pixel lies to the right, beyond jumps by as much in all as columns lie between, less what
// disparity rises slowly.
void ProjectorShadow::find_spans() {
  const float most = (high_ - low_) / (1.0f - kSmooth_px);
  std::size_t first = 0, last = 0;
  float rise = 0.0f;  // of all jumps within `most` of the one looked at
  for (const Jump& jump : jumps_) {
    const auto reach_all = static_cast<std::size_t>(most) + kAround_px;
    for (; last < jumps_.size() && jumps_[last].column <= jump.column + reach_all; ++last)
      rise += jumps_[last].rise;
    for (; jumps_[first].column + reach_all < jump.column; ++first) rise -= jumps_[first].rise;
    const std::size_t reach =
        static_cast<std::size_t>(std::min(rise / (1.0f - kSmooth_px), most)) + kAround_px;
    const std::size_t begin = jump.column > reach ? jump.column - reach : 0;
    const std::size_t end = std::min(jump.column + reach + 2, width_);
    if (!spans_.empty() && begin <= spans_.back().second) {
      spans_.back().first = std::min(spans_.back().first, begin);
      spans_.back().second = std::max(spans_.back().second, end);
    } else {
      spans_.emplace_back(begin, end);
    }
  }
}

void ProjectorShadow::project(std::size_t begin, std::size_t end) {
  float before = begin > 0 ? disparity_[begin - 1] : 0.0f;
  for (std::size_t u = begin; u < end; ++u) {
    const float d = disparity_[u];
    if (d != 0.0f) {
      std::int32_t first = column_[u], last = first;
      // a surface that the camera sees without a gap has none for the projector either
      if (before > 0.0f && std::abs(before - d) < 1.0f) {
        first = std::min(first, column_[u - 1] + 1);
        last = std::max(last, column_[u - 1] - 1);
      }
      for (std::int32_t c = std::max(first, 0); c <= last; ++c) {
        float& nearest = nearest_[static_cast<std::size_t>(c)];
        nearest = std::max(nearest, d);
      }
    }
    before = d;
  }
}

void ProjectorShadow::apply(float* inverse_depth) const {
  for (const auto& [begin, end] : spans_)
    for (std::size_t u = begin; u < end; ++u) {
      const float d = disparity_[u];
      const bool hidden =
          d > 0.0f && column_[u] >= 0 && nearest_[static_cast<std::size_t>(column_[u])] > d + 1.0f;
      if (hidden) inverse_depth[u] = std::numeric_limits<float>::quiet_NaN();
    }
}

}  // namespace colift::sim_hal
