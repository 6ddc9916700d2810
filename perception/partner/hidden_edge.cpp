#include "perception/partner/hidden_edge.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace colift::perception {
namespace {

// Points of a body against which the hidden edge is held: a forearm has some tens of them.
constexpr std::size_t kMaxBodyPoints = 400;
// What is seen of him is his back or his side; his hand is on the other side of him, about as far beyond it
// wherever it is. A point of the edge so much farther than the nearest one is a standard deviation less
// likely.
constexpr float kReach_m = 0.08F;
// His contact lies on the edge, by the half width of a hand, and at any height that he can hold it at.
constexpr double kOnEdge_m = 0.05;

/// Mean and covariance of the hidden points, weighted by their distance from the body.
PartnerGrasp most_likely_grasp(std::span<const Eigen::Vector3f> hidden, const OrganisedCloud& current,
                               std::span<const std::uint32_t> body) {
  std::vector<Eigen::Vector3f> skin;
  const std::size_t step = body.size() / kMaxBodyPoints + 1;
  skin.reserve(body.size() / step + 1);
  for (std::size_t i = 0; i < body.size(); i += step)
    if (current.seen(body[i])) skin.push_back(current.point(body[i]).cast<float>());
  std::vector<float> away(hidden.size(), std::numeric_limits<float>::max());
  for (std::size_t k = 0; k < hidden.size(); ++k)
    for (const Eigen::Vector3f& p : skin) away[k] = std::min(away[k], (hidden[k] - p).squaredNorm());
  for (float& a : away) a = std::sqrt(a);
  const float least = *std::min_element(away.begin(), away.end());
  const auto weight = [&](std::size_t k) {
    const float sigmas = (away[k] - least) / kReach_m;
    return static_cast<double>(std::exp(-0.5F * sigmas * sigmas));
  };
  PartnerGrasp out;
  double sum = 0.0;
  for (std::size_t k = 0; k < hidden.size(); ++k) {
    sum += weight(k);
    out.position += weight(k) * hidden[k].cast<double>();
  }
  out.position /= sum;
  for (std::size_t k = 0; k < hidden.size(); ++k) {
    const hal::Vec3 d = hidden[k].cast<double>() - out.position;
    out.covariance += weight(k) / sum * (d * d.transpose());
  }
  out.covariance.diagonal().array() += kOnEdge_m * kOnEdge_m;
  out.points = static_cast<std::size_t>(std::lround(sum));
  return out;
}

}  // namespace

std::optional<HiddenEdge> find_hidden_edge(std::span<const Eigen::Vector3f> edge,
                                           const OrganisedCloud& current, std::span<const std::uint32_t> body,
                                           double gap_m) {
  if (edge.empty() || body.empty()) return std::nullopt;
  const int width = current.width();
  std::vector<Eigen::Vector3f> hidden;
  double u_sum = 0.0, v_sum = 0.0;
  for (const Eigen::Vector3f& p : edge) {
    const OrganisedCloud::Projection at = current.project(p.cast<double>());
    if (!(at.depth_m > 0.0) || !current.contains(at.u, at.v)) continue;
    const auto i = static_cast<std::uint32_t>(std::lround(at.v) * width + std::lround(at.u));
    if (i >= current.size() || !(current.depth_m[i] < at.depth_m - gap_m)) continue;
    if (!std::binary_search(body.begin(), body.end(), i)) continue;
    hidden.push_back(p);
    u_sum += at.u;
    v_sum += at.v;
  }
  if (hidden.empty()) return std::nullopt;
  // in the row of the hidden edge's middle the body ends sooner on one side
  const double u = u_sum / static_cast<double>(hidden.size());
  const auto row = static_cast<std::uint32_t>(std::lround(v_sum / static_cast<double>(hidden.size())));
  const auto first = std::lower_bound(body.begin(), body.end(), row * static_cast<std::uint32_t>(width));
  const auto last = std::lower_bound(first, body.end(), (row + 1) * static_cast<std::uint32_t>(width));
  HiddenEdge out;
  out.fraction = static_cast<double>(hidden.size()) / static_cast<double>(edge.size());
  if (first != last) {
    const double left = *first % static_cast<std::uint32_t>(width),
                 right = *(last - 1) % static_cast<std::uint32_t>(width);
    out.to_right = u - left < right - u;
  }
  hal::Vec3 aside = (out.to_right ? 1.0 : -1.0) * current.X_WC.linear().col(0);
  aside.z() = 0.0;
  if (aside.norm() > 1e-3) out.aside_W = aside.normalized();
  out.grasp = most_likely_grasp(hidden, current, body);
  return out;
}

}  // namespace colift::perception
