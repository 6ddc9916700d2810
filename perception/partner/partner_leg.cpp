#include "perception/partner/partner_leg.hpp"

#include <algorithm>
#include <cmath>

namespace colift::perception {
namespace {

// Placed between 491 hands and 412 legs in synthetic frames (docs/decisions/0003).
constexpr double kLow_m = 0.20;   // what is touched lower may be held by a hand beside the ground
constexpr double kHip_m = 0.85;   // higher than this no leg touches
constexpr double kFoot_m = 0.12;  // what lies lower is a foot
// Skin of the wrist below a palm that hangs from an edge (m): of a low touch, what lies lower is a foot.
constexpr double kWristBelow_m = 0.145;
constexpr double kUnder_m = 0.20;       // how far aside a leg's foot stands at most
constexpr double kStanding_m2 = 0.001;  // hands higher than kLow_m have nothing there
constexpr double kBesideFrom_m = 0.10, kBesideTo_m = 0.25;
constexpr double kShoe_m2 = 0.0045;  // beside the touch; hands and forearms show 0.0038 at most
// above and below the touch; hands over an edge show 0.009 and 0.0064 at most
constexpr double kPassFrom_m = 0.06, kPassTo_m = 0.20, kPassing_m2 = 0.0075;
constexpr double kAround_m = 0.25;
constexpr double kThick_m2 = 0.048;  // hands with forearms show 0.044 at most
constexpr double kOtherLeg_m2 = 0.034;
constexpr std::size_t kEvery = 3;  // pixels are dense enough for areas

}  // namespace

LegSign leg_sign(const OrganisedCloud& current, std::span<const std::uint32_t> body_pixels,
                 const Vec3& touch_W, const Ground& ground, bool beside_a_leg) {
  const auto touch = touch_W.cast<float>().eval();
  const auto up = ground.plane.normal.cast<float>().eval();
  const auto touch_height = static_cast<float>(ground.plane.height(touch_W));
  const double per_pixel = static_cast<double>(kEvery) / (current.intrinsics.fx * current.intrinsics.fy);
  constexpr auto kPass2 = static_cast<float>(kPassTo_m * kPassTo_m);
  constexpr auto kAround2 = static_cast<float>(kAround_m * kAround_m);
  float foot = static_cast<float>(kFoot_m);
  if (static_cast<double>(touch_height) >= kLow_m)
    foot = std::min(foot, touch_height - static_cast<float>(kWristBelow_m));
  double under = 0.0, beside = 0.0, above = 0.0, below = 0.0, around = 0.0;
  for (std::size_t k = 0; k < body_pixels.size(); k += kEvery) {
    const std::uint32_t i = body_pixels[k];
    const Eigen::Vector3f d(current.x[i] - touch.x(), current.y[i] - touch.y(), current.z[i] - touch.z());
    const float rise = up.dot(d), distance2 = d.squaredNorm();
    const float aside = std::sqrt(std::max(0.0f, distance2 - rise * rise));
    if (!(aside < static_cast<float>(kAround_m))) continue;
    const auto z = static_cast<double>(current.depth_m[i]);
    const double area = per_pixel * z * z;
    if (distance2 < kAround2) around += area;
    if (distance2 < kPass2) {
      if (rise > static_cast<float>(kPassFrom_m)) above += area;
      if (rise < -static_cast<float>(kPassFrom_m)) below += area;
    }
    if (touch_height + rise > foot) continue;
    if (aside < static_cast<float>(kUnder_m)) under += area;
    if (aside > static_cast<float>(kBesideFrom_m) && aside < static_cast<float>(kBesideTo_m)) beside += area;
  }
  const auto height = static_cast<double>(touch_height);
  if (height >= kLow_m && height <= kHip_m && under > kStanding_m2) return LegSign::Standing;
  if (height < kLow_m && beside > kShoe_m2) return LegSign::Shoe;
  if (height <= kHip_m && above > kPassing_m2 && below > kPassing_m2) return LegSign::Passing;
  if (around > (beside_a_leg ? kOtherLeg_m2 : kThick_m2)) return LegSign::Thick;
  return LegSign::None;
}

}  // namespace colift::perception
