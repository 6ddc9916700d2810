#include "control/arm/yield_compensation.hpp"

#include <algorithm>

namespace colift::control {
namespace {

constexpr double kLeast_n = 5.0;                 // of a load: less is an error of the estimate
constexpr double kGone = 0.3, kBack = 0.6;       // of what it was
constexpr double kSure_s = 0.15, kFade_s = 0.2;  // what a swinging load feels like passes sooner

}  // namespace

void YieldCompensation::start(const hal::JointVector& superposed_nm, double support_n) {
  superposed_nm_ = superposed_nm;
  support_n_ = support_n;
  part_ = 1.0;
  changed_s_ = 0.0;
  lost_ = false;
}

hal::JointVector YieldCompensation::step(double load_n, bool quiet, double dt_s) {
  if (support_n_ > kLeast_n && dt_s > 0.0) {
    const bool other = lost_ ? load_n > kBack * support_n_ : quiet && load_n < kGone * support_n_;
    changed_s_ = other ? changed_s_ + dt_s : 0.0;
    if (changed_s_ >= kSure_s) {
      lost_ = !lost_;
      changed_s_ = 0.0;
    }
    const double step = dt_s / kFade_s;
    part_ = std::clamp(part_ + (lost_ ? -step : step), 0.0, 1.0);
  }
  return part_ * superposed_nm_;
}

}  // namespace colift::control
