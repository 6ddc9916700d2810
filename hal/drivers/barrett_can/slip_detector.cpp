#include "hal/drivers/barrett_can/slip_detector.hpp"

#include <algorithm>
#include <cmath>

namespace colift::hal::barrett {

namespace {
constexpr double kFallen_s = 1.0;  // slow changes are the load's, quick ones a slip's
constexpr double kRisen_s = 0.3;   // longer than a jerk
constexpr int kInARow = 2;
}  // namespace

bool SlipDetector::drops(Trace& trace, const std::array<double, kFingers>& values,
                         const std::array<bool, kFingers>& holding, double least, double dt_s) const {
  std::array<bool, kFingers> of{};
  double sum = 0.0;
  for (std::size_t f = 0; f < kFingers; ++f) {
    of[f] = holding[f] && !std::isnan(values[f]);
    if (of[f]) sum += values[f];
  }
  if (of != trace.of) {
    trace = {sum, sum, of, 0};
    return false;
  }
  trace.below = trace.reference >= least && sum < limits_.share * trace.reference ? trace.below + 1 : 0;
  if (trace.below == 0) {
    const double in_s = sum > trace.reference ? kRisen_s : kFallen_s;
    trace.reference += std::min(1.0, dt_s / in_s) * (sum - trace.reference);
    trace.reference = std::min(trace.reference, trace.begin);
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
    strain_ = pad_ = {};
    closing_ = 0;
    (void)drops(strain_, strain_nm, holding, limits_.min_nm, 0.0);
    (void)drops(pad_, pad_n, holding, limits_.min_n, 0.0);
    return;
  }
  if (at <= last_) return;  // nothing new
  const double dt_s = seconds(at - last_);
  last_ = at;
  // both are asked, so that both keep their references
  const bool strain = drops(strain_, strain_nm, holding, limits_.min_nm, dt_s);
  const bool pad = drops(pad_, pad_n, holding, limits_.min_n, dt_s);
  double closed_rad = 0.0;
  int fingers = 0;
  for (std::size_t f = 0; f < kFingers; ++f) {
    if (!holding[f]) continue;
    closed_rad += inner_rad[f] - start_rad_[f];
    ++fingers;
  }
  closing_ = fingers > 0 && closed_rad > fingers * limits_.closed_rad ? closing_ + 1 : 0;
  if (strain || pad || closing_ >= kInARow) slipped_ = true;
}

}  // namespace colift::hal::barrett
