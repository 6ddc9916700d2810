#include "perception/partner/partner_leg.hpp"

#include <algorithm>
#include <cmath>

namespace colift::perception {
namespace {

constexpr std::size_t kEvery = 3;  // pixels are dense enough for areas

}  // namespace

LegSign leg_sign(const OrganisedCloud& current, std::span<const std::uint32_t> body_pixels,
                 const Vec3& touch_W, const Ground& ground, bool beside_a_leg, const LegConfig& c) {
  const auto touch = touch_W.cast<float>().eval();
  const auto up = ground.plane.normal.cast<float>().eval();
  const auto touch_height = static_cast<float>(ground.plane.height(touch_W));
  const double per_pixel = static_cast<double>(kEvery) / (current.intrinsics.fx * current.intrinsics.fy);
  const auto pass2 = static_cast<float>(c.limb_to_m * c.limb_to_m);
  const auto around2 = static_cast<float>(c.body_radius_m * c.body_radius_m);
  const auto body_radius = static_cast<float>(c.body_radius_m), limb_from = static_cast<float>(c.limb_from_m),
             foot_aside = static_cast<float>(c.foot_aside_m), shoe_from = static_cast<float>(c.shoe_from_m),
             shoe_to = static_cast<float>(c.shoe_to_m);
  float foot = static_cast<float>(c.foot_height_m);
  if (static_cast<double>(touch_height) >= c.min_height_m)
    foot = std::min(foot, touch_height - static_cast<float>(c.wrist_below_palm_m));
  double under = 0.0, beside = 0.0, above = 0.0, below = 0.0, around = 0.0;
  for (std::size_t k = 0; k < body_pixels.size(); k += kEvery) {
    const std::uint32_t i = body_pixels[k];
    const Eigen::Vector3f d(current.x[i] - touch.x(), current.y[i] - touch.y(), current.z[i] - touch.z());
    const float rise = up.dot(d), distance2 = d.squaredNorm();
    const float aside = std::sqrt(std::max(0.0f, distance2 - rise * rise));
    if (!(aside < body_radius)) continue;
    const auto z = static_cast<double>(current.depth_m[i]);
    const double area = per_pixel * z * z;
    if (distance2 < around2) around += area;
    if (distance2 < pass2) {
      if (rise > limb_from) above += area;
      if (rise < -limb_from) below += area;
    }
    if (touch_height + rise > foot) continue;
    if (aside < foot_aside) under += area;
    if (aside > shoe_from && aside < shoe_to) beside += area;
  }
  const auto height = static_cast<double>(touch_height);
  if (height >= c.min_height_m && height <= c.max_height_m && under > c.min_foot_area_m2)
    return LegSign::Standing;
  if (height < c.min_height_m && beside > c.min_shoe_area_m2) return LegSign::Shoe;
  if (height <= c.max_height_m && above > c.min_limb_area_m2 && below > c.min_limb_area_m2)
    return LegSign::Passing;
  if (around > (beside_a_leg ? c.min_second_leg_area_m2 : c.min_body_area_m2)) return LegSign::Thick;
  return LegSign::None;
}

}  // namespace colift::perception
