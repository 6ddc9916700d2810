#include "control/arm/yield_law.hpp"

#include <algorithm>
#include <cmath>

namespace colift::control {
namespace {

constexpr double kWidest = 3.0;  // times the configured band

}  // namespace

YieldLaw::YieldLaw(const ForceMonitorConfig& config)
    : stiffness_nm_rad_(config.yield_stiffness_nm_rad),
      band_rad_(config.yield_band_rad),
      relaxed_band_rad_(std::min(config.yield_relaxed_band_rad, config.yield_band_rad)),
      relax_s_(config.yield_relax_s),
      rest_s_(config.yield_rest_filter_s),
      max_held_nm_(config.yield_max_held_nm),
      still_rad_s_(config.yield_still_rad_s),
      swing_s_(config.yield_swing_s) {}

void YieldLaw::rest(const hal::JointVector& spring_nm, double dt_s) {
  if (!spring_nm.allFinite() || dt_s <= 0.0) return;
  held_nm_ += std::min(1.0, dt_s / rest_s_) * (spring_nm - held_nm_);
  held_nm_ = held_nm_.cwiseMax(-max_held_nm_).cwiseMin(max_held_nm_);
}

hal::JointVector YieldLaw::step(const hal::JointVector& q_rad, const hal::JointVector& commanded_rad,
                                const hal::JointVector& stiffness_nm_rad, bool pressed, double dt_s) {
  const double part = pressed && dt_s > 0.0 && relax_s_ > 0.0 ? 1.0 - std::exp(-dt_s / relax_s_) : 0.0;
  left_alone_s_ = pressed ? 0.0 : left_alone_s_ + std::max(dt_s, 0.0);
  hal::JointVector goal = commanded_rad;
  for (int i = 0; i < hal::kArmJoints; ++i) {
    // what counts is the torque: a stiff joint has the narrower band, one that is soft already the wider
    const double soft = std::min(kWidest, stiffness_nm_rad_ / std::max(stiffness_nm_rad[i], 1.0));
    const double band = soft * band_rad_, relaxed = soft * relaxed_band_rad_;
    const double away = q_rad[i] - commanded_rad[i];
    const double moved = last_known_ ? q_rad[i] - last_rad_[i] : 0.0;
    const bool swings_out =
        left_alone_s_ <= swing_s_ && std::copysign(1.0, away) * moved > still_rad_s_ * dt_s;
    if (pressed || swings_out) goal[i] += away - std::clamp(away, -band, band);
    const double left = q_rad[i] - goal[i];
    goal[i] += part * (left - std::clamp(left, -relaxed, relaxed));
  }
  last_rad_ = q_rad;
  last_known_ = true;
  return goal;
}

}  // namespace colift::control
