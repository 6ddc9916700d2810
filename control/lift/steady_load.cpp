#include "control/lift/steady_load.hpp"

#include <cmath>

namespace colift::control {
namespace {

// slower than a hand's tremor of 8 to 12 Hz, faster than an object that two hands swing
constexpr double kFast_s = 0.2, kSlow_s = 0.6;

void approach(double& mean_n, double load_n, double dt_s, double time_constant_s) {
  mean_n += (load_n - mean_n) * (1.0 - std::exp(-dt_s / time_constant_s));
}

}  // namespace

void SteadyLoad::update(double load_n, double dt_s, double max_change_n) {
  if (!std::isfinite(load_n) || !(dt_s > 0.0)) return;
  if (!begun_) {
    begun_ = true;
    fast_n_ = slow_n_ = load_n;
    return;
  }
  approach(fast_n_, load_n, dt_s, kFast_s);
  approach(slow_n_, load_n, dt_s, kSlow_s);
  steady_s_ = std::abs(fast_n_ - slow_n_) <= max_change_n ? steady_s_ + dt_s : 0.0;
}

}  // namespace colift::control
