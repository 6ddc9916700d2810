#include "sim_hal/judge/load_rules.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "hal/types/units.hpp"

namespace colift::sim_hal {
namespace {

constexpr double kOpens_rad = 0.03;                         // of the fingers' mean
constexpr double kSupported_n = 3.0, kSupportedPart = 0.1;  // below that somebody else bears the object
constexpr double kFalls_s = 0.5, kDropped_m = 0.003, kTilted_rad = 0.009;  // what was not supported moves
constexpr double kLifted_m = 0.01, kNearTop = 0.95, kStillUp = 0.8;

}  // namespace

void LoadRules::tick(const TickReport& r, std::vector<std::string>& breaches) {
  Moment& moment = past_[tick_++ % kBefore_ms];
  const Moment before = moment;
  moment = {r.truth.robot_force_W.z(), r.truth.height_m, r.truth.tilt_rad};

  double mean = 0.0;
  for (const double q : r.hand.finger_rad) mean += q / hal::kFingers;
  if (r.hand.held && r.truth.robot_touches_object) {
    closed_rad_ = std::max(closed_rad_.value_or(mean), mean);
  } else if (closed_rad_ && r.hand.moving && mean < *closed_rad_ - kOpens_rad) {  // nobody pushes them open
    const double limit = std::max(kSupported_n, kSupportedPart * r.truth.mass_kg * hal::kGravity_m_s2);
    if (before.borne_n > limit) opening_ = Opening{r.t_s, before};
    closed_rad_.reset();
  }
  if (opening_ && r.t_s - opening_->t_s < kFalls_s) {
    const double dropped = opening_->before.height_m - r.truth.height_m;
    const double tilted = std::abs(r.truth.tilt_rad - opening_->before.tilt_rad);
    if (dropped > kDropped_m || tilted > kTilted_rad) {
      breaches.push_back(fmt::format(
          "I4: the hand opened at {:.3f} s with {:.0f} N on it, and the object moved ({:.0f} mm, {:.1f} deg)",
          opening_->t_s, opening_->before.borne_n, 1000.0 * dropped, hal::rad_to_deg(tilted)));
      opening_.reset();
    }
  }
  const double height_m = r.truth.height_m;
  const bool held = r.truth.partner_W.has_value();
  // who takes hold again in the air need not raise it as high as it was before
  if (held && !held_) top_m_ = height_m;
  held_ = held;
  top_m_ = std::max(top_m_, height_m);
  max_height_m_ = std::max(max_height_m_, height_m);
  if (max_height_m_ > kLifted_m && height_m > kNearTop * top_m_ && height_m > kStillUp * max_height_m_)
    partner_at_top_ = held;
}

void LoadRules::lifted(std::vector<std::string>& breaches) const {
  if (max_height_m_ < kLifted_m)
    breaches.push_back(
        fmt::format("I8: reported lifted, but the object rose by {:.0f} mm only", 1000.0 * max_height_m_));
  else if (!partner_at_top_)
    breaches.emplace_back("I8: reported lifted, but the partner did not hold at the top");
}

}  // namespace colift::sim_hal
