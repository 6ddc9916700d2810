#include "control/arm/yield_law.hpp"

#include <algorithm>
#include <cmath>

namespace colift::control {
namespace {

constexpr double kRest_s = 0.2;     // time constant of what the springs hold
constexpr double kMaxHeld_nm = 10;  // more is no error of a load's estimate

}  // namespace

YieldLaw::YieldLaw(const ForceMonitorConfig& config)
    : stiffness_nm_rad_(config.yield_stiffness_nm_rad),
      band_rad_(config.yield_band_rad),
      relaxed_band_rad_(std::min(config.yield_relaxed_band_rad, config.yield_band_rad)),
      relax_s_(config.yield_relax_s) {}

void YieldLaw::rest(const hal::JointVector& q_rad, const hal::JointVector& commanded_rad,
                    double stiffness_nm_rad, double dt_s) {
  if (!q_rad.allFinite() || dt_s <= 0.0) return;
  const hal::JointVector spring_nm = stiffness_nm_rad * (commanded_rad - q_rad);
  held_nm_ += std::min(1.0, dt_s / kRest_s) * (spring_nm - held_nm_);
  held_nm_ = held_nm_.cwiseMax(-kMaxHeld_nm).cwiseMin(kMaxHeld_nm);
}

hal::JointVector YieldLaw::step(const hal::JointVector& q_rad, const hal::JointVector& commanded_rad,
                                double stiffness_nm_rad, bool pressed, double dt_s) const {
  const auto within = [&](const hal::JointVector& from, double band) -> hal::JointVector {
    return from.cwiseMax((q_rad.array() - band).matrix()).cwiseMin((q_rad.array() + band).matrix());
  };
  // while the joints are still stiff the band is the narrower: what counts is the torque
  const double soft = std::min(1.0, stiffness_nm_rad_ / std::max(stiffness_nm_rad, 1.0));
  hal::JointVector goal = within(commanded_rad, soft * band_rad_);
  if (!pressed || dt_s <= 0.0) return goal;
  const double part = relax_s_ > 0.0 ? 1.0 - std::exp(-dt_s / relax_s_) : 1.0;
  goal += part * (within(goal, soft * relaxed_band_rad_) - goal);
  return goal;
}

}  // namespace colift::control
