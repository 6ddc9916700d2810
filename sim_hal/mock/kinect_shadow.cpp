#include "sim_hal/mock/kinect_shadow.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace colift::sim_hal {
namespace {

constexpr double kBaseline_m = 0.075;
constexpr float kNearest_m = 0.3f;  // nothing nearer is seen, which bounds the disparity
// A row along which disparity changes by less per pixel has no shadow: then columns of the projector follow
// each other in the order of the camera's, and at most four neighbours share one.
constexpr float kSmooth_px = 0.15f;
constexpr std::size_t kAround_px = 4;

}  // namespace

ProjectorShadow::ProjectorShadow(int width, double fx)
    : shift_(static_cast<float>(fx * kBaseline_m)),
      margin_(static_cast<int>(shift_ / kNearest_m) + 2),
      disparity_(static_cast<std::size_t>(width)),
      nearest_(static_cast<std::size_t>(width + margin_)),
      column_(static_cast<std::size_t>(width)) {}

void ProjectorShadow::find(const float* depth_m) {
  for (std::size_t u = 0; u < disparity_.size(); ++u) {
    const float d = shift_ / depth_m[u];
    disparity_[u] = depth_m[u] > kNearest_m ? d : 0.0f;  // 0 for NaN
  }
  for (std::size_t u = 0; u < column_.size(); ++u)
    column_[u] = static_cast<std::int32_t>(static_cast<float>(static_cast<std::int32_t>(u) + margin_) -
                                           disparity_[u] + 0.5f);
  find_spans();
  if (spans_.empty()) return;
  std::fill(nearest_.begin(), nearest_.end(), 0.0f);
  for (const auto& [begin, end] : spans_) project(begin, end);
}

void ProjectorShadow::find_spans() {
  spans_.clear();
  const std::size_t n = disparity_.size();
  float low = std::numeric_limits<float>::infinity(), high = 0.0f;
  for (const float d : disparity_) {
    low = std::min(low, d > 0.0f ? d : low);
    high = std::max(high, d);
  }
  if (!(high > low)) return;
  // what hides a pixel lies beyond a jump, by no more than the jump's disparity
  const std::size_t reach = static_cast<std::size_t>(high - low) + kAround_px;
  for (std::size_t u = 0; u + 1 < n; ++u) {
    if (std::abs(disparity_[u + 1] - disparity_[u]) < kSmooth_px) continue;
    const std::size_t begin = u > reach ? u - reach : 0, end = std::min(u + reach + 2, n);
    if (!spans_.empty() && begin <= spans_.back().second) {
      spans_.back().second = end;
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

void ProjectorShadow::apply(float* depth_m) const {
  for (const auto& [begin, end] : spans_)
    for (std::size_t u = begin; u < end; ++u) {
      const float d = disparity_[u];
      const bool hidden =
          d > 0.0f && column_[u] >= 0 && nearest_[static_cast<std::size_t>(column_[u])] > d + 1.0f;
      if (hidden) depth_m[u] = std::numeric_limits<float>::quiet_NaN();
    }
}

}  // namespace colift::sim_hal
