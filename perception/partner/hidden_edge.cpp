#include "perception/partner/hidden_edge.hpp"

#include <algorithm>
#include <cmath>

namespace colift::perception {

std::optional<HiddenEdge> find_hidden_edge(std::span<const Eigen::Vector3f> edge,
                                           const OrganisedCloud& current, std::span<const std::uint32_t> body,
                                           double gap_m) {
  if (edge.empty() || body.empty()) return std::nullopt;
  const int width = current.width();
  std::size_t hidden = 0;
  double u_sum = 0.0, v_sum = 0.0;
  for (const Eigen::Vector3f& p : edge) {
    const OrganisedCloud::Projection at = current.project(p.cast<double>());
    if (!(at.depth_m > 0.0) || !current.contains(at.u, at.v)) continue;
    const auto i = static_cast<std::uint32_t>(std::lround(at.v) * width + std::lround(at.u));
    if (i >= current.size() || !(current.depth_m[i] < at.depth_m - gap_m)) continue;
    if (!std::binary_search(body.begin(), body.end(), i)) continue;
    ++hidden;
    u_sum += at.u;
    v_sum += at.v;
  }
  if (hidden == 0) return std::nullopt;
  // in the row of the hidden edge's middle the body ends sooner on one side
  const double u = u_sum / static_cast<double>(hidden);
  const auto row = static_cast<std::uint32_t>(std::lround(v_sum / static_cast<double>(hidden)));
  const auto first = std::lower_bound(body.begin(), body.end(), row * static_cast<std::uint32_t>(width));
  const auto last = std::lower_bound(first, body.end(), (row + 1) * static_cast<std::uint32_t>(width));
  HiddenEdge out;
  out.fraction = static_cast<double>(hidden) / static_cast<double>(edge.size());
  if (first != last) {
    const double left = *first % static_cast<std::uint32_t>(width),
                 right = *(last - 1) % static_cast<std::uint32_t>(width);
    out.to_right = u - left < right - u;
  }
  hal::Vec3 aside = (out.to_right ? 1.0 : -1.0) * current.X_WC.linear().col(0);
  aside.z() = 0.0;
  if (aside.norm() > 1e-3) out.aside_W = aside.normalized();
  return out;
}

}  // namespace colift::perception
