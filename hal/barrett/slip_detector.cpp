#include "hal/barrett/slip_detector.hpp"

#include <algorithm>
#include <cmath>

namespace colift::hal::barrett {

namespace {
constexpr double kFollow_s = 1.0;  // slow changes are the load's, quick ones a slip's
constexpr int kInARow = 2;
}  // namespace

bool SlipDetector::drops(Trace& trace, double value, double least, double dt_s) const {
  if (std::isnan(value)) return false;
  trace.below = trace.reference >= least && value < limits_.share * trace.reference ? trace.below + 1 : 0;
  if (trace.below == 0) {
    const double rate = value > trace.reference ? 1.0 : std::min(1.0, dt_s / kFollow_s);
    trace.reference += rate * (value - trace.reference);
  }
  return trace.below >= kInARow;
}

void SlipDetector::add(Timestamp at, const std::array<double, kFingers>& inner_rad,
                       const std::array<double, kFingers>& strain_nm,
                       const std::array<double, kFingers>& pad_n, const std::array<bool, kFingers>& holding) {
  if (!started_) {
    started_ = true;
    last_ = at;
    start_rad_ = inner_rad;
    for (std::size_t f = 0; f < kFingers; ++f) {
      strain_[f] = {std::isnan(strain_nm[f]) ? 0.0 : strain_nm[f], 0};
      pad_[f] = {std::isnan(pad_n[f]) ? 0.0 : pad_n[f], 0};
    }
    return;
  }
  if (at <= last_) return;  // nothing new
  const double dt_s = seconds(at - last_);
  last_ = at;
  for (std::size_t f = 0; f < kFingers; ++f) {
    if (!holding[f]) continue;
    // both are asked, so that both keep their references
    const bool strain = drops(strain_[f], strain_nm[f], limits_.least_nm, dt_s);
    const bool pad = drops(pad_[f], pad_n[f], limits_.least_n, dt_s);
    if (strain || pad || inner_rad[f] - start_rad_[f] > limits_.closed_rad) slipped_ = true;
  }
}

}  // namespace colift::hal::barrett
