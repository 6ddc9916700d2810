#include "perception/partner/contact_cover.hpp"

#include <algorithm>
#include <utility>

namespace colift::perception {

void HandPixels::seen(const OrganisedCloud& reference, const hal::DepthFrame& frame,
                      std::span<const std::uint32_t> changed, const hal::Vec3& contact_W) {
  const hal::Vec3 contact_C = reference.X_WC.inverse() * contact_W;
  std::vector<std::uint32_t> now;
  const hal::CameraIntrinsics& k = frame.intrinsics;
  for (const std::uint32_t i : changed) {
    if (i >= frame.depth_m.size()) continue;
    const double z = frame.depth_m[i];
    const int u = static_cast<int>(i) % k.width, v = static_cast<int>(i) / k.width;
    const hal::Vec3 p_C((u - k.cx) / k.fx * z, (v - k.cy) / k.fy * z, z);
    if ((p_C - contact_C).norm() < config_.radius_m) now.push_back(i);
  }
  // what is left of a hand that his body hides more and more, or a rim that flickers, is no picture of the
  // hand
  const bool same_place = (contact_C - contact_C_).norm() < config_.radius_m;
  if (same_place && 2 * now.size() < pixels_.size()) return;
  pixels_ = std::move(now);
  contact_C_ = contact_C;
}

bool HandPixels::hidden(const OrganisedCloud& reference, const hal::DepthFrame& frame,
                        std::span<const std::uint32_t> robot_pixels, const NoiseModel& noise) const {
  if (pixels_.empty() || frame.depth_m.size() != reference.size()) return false;
  std::size_t covered = 0, uncovered = 0;
  for (const std::uint32_t i : pixels_) {
    const double z = frame.depth_m[i], then = reference.depth_m[i];
    if (z > 0.0 && z < contact_C_.z() - config_.gap_m)
      ++covered;
    else if (std::binary_search(robot_pixels.begin(), robot_pixels.end(), i))
      ++covered;
    else if (z > 0.0 && then > 0.0 && z > then - 3.0 * noise.sigma(then) - noise.step(then))
      ++uncovered;
  }
  const auto all = static_cast<double>(pixels_.size());
  return static_cast<double>(covered) >= config_.min_covered * all &&
         static_cast<double>(uncovered) <= config_.max_uncovered * all;
}

}  // namespace colift::perception
