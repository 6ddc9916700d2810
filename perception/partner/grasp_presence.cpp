#include "perception/partner/grasp_presence.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace colift::perception {
namespace {

/// Smallest depth of the reference around a pixel: edges are ragged. Infinity where nothing was seen at all.
double nearest(const OrganisedCloud& reference, int u, int v, int edge_px) {
  double z = std::numeric_limits<double>::infinity();
  for (int y = std::max(0, v - edge_px); y <= std::min(reference.height() - 1, v + edge_px); ++y)
    for (int x = std::max(0, u - edge_px); x <= std::min(reference.width() - 1, u + edge_px); ++x) {
      const auto i = static_cast<std::size_t>(y) * static_cast<std::size_t>(reference.width()) +
                     static_cast<std::size_t>(x);
      if (reference.seen(i)) z = std::min(z, static_cast<double>(reference.depth_m[i]));
    }
  return z;
}

}  // namespace

std::optional<HandSighting> hand_at_contact(const OrganisedCloud& reference, const hal::DepthFrame& frame,
                                            const hal::Pose& X_Wnow_Wref, const hal::Vec3& contact_W,
                                            const NoiseModel& noise, const PresenceConfig& config) {
  const hal::Vec3 now_W = X_Wnow_Wref * contact_W;
  const OrganisedCloud::Projection middle = reference.project(now_W);
  if (middle.depth_m <= 0.1 || !reference.contains(middle.u, middle.v)) return std::nullopt;
  const hal::CameraIntrinsics& k = frame.intrinsics;
  const double radius_m = std::max(config.radius_m, config.motion_radius_m);
  const double half_px = radius_m * k.fx / std::max(middle.depth_m - radius_m, 0.1);
  const int u0 = std::max(0, static_cast<int>(middle.u - half_px));
  const int u1 = std::min(k.width - 1, static_cast<int>(middle.u + half_px));
  const int v0 = std::max(0, static_cast<int>(middle.v - half_px));
  const int v1 = std::min(k.height - 1, static_cast<int>(middle.v + half_px));
  const hal::Pose X_Wref_Wnow = X_Wnow_Wref.inverse();
  HandSighting sighting;
  for (int v = v0; v <= v1; ++v)
    for (int u = u0; u <= u1; ++u) {
      const double z = frame.depth_m[static_cast<std::size_t>(v) * static_cast<std::size_t>(k.width) +
                                     static_cast<std::size_t>(u)];
      if (!(z > 0.0)) continue;
      const hal::Vec3 p_W = reference.X_WC * hal::Vec3((u - k.cx) / k.fx * z, (v - k.cy) / k.fy * z, z);
      const double from_contact_m = (p_W - now_W).norm();
      if (from_contact_m > radius_m) continue;
      const hal::Vec3 then_W = X_Wref_Wnow * p_W;
      const OrganisedCloud::Projection then = reference.project(then_W);
      if (then.depth_m <= 0.0 || !reference.contains(then.u, then.v)) continue;
      const double behind = nearest(reference, static_cast<int>(std::lround(then.u)),
                                    static_cast<int>(std::lround(then.v)), config.edge_px);
      if (!std::isfinite(behind)) continue;
      if (then.depth_m >= behind - config.margin_m - config.sigmas * noise.sigma(behind)) continue;
      const double pixel_m2 = z * z / (k.fx * k.fy);
      if (from_contact_m <= config.radius_m) sighting.area_m2 += pixel_m2;
      if (from_contact_m > config.motion_radius_m) continue;
      sighting.motion_area_m2 += pixel_m2;
      sighting.centroid_m += pixel_m2 * (then_W - contact_W);
    }
  if (sighting.motion_area_m2 > 0.0) sighting.centroid_m /= sighting.motion_area_m2;
  return sighting;
}

}  // namespace colift::perception
