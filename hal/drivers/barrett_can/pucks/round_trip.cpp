#include "hal/drivers/barrett_can/pucks/round_trip.hpp"

#include <algorithm>
#include <cmath>

namespace colift::hal::barrett {

void RoundTrip::note_answer(Duration age) {
  worst_now_ = std::max(worst_now_, age);
  if (age > base_) ++late_now_;
  measured_ = true;
}

void RoundTrip::note_late(Duration age, Timestamp now) {
  worst_now_ = std::max(worst_now_, std::min(age, kLatest));
  ++late_now_;
  measured_ = true;
  if (patient_until_ < now) be_patient(kWindow, now);
}

void RoundTrip::step(Timestamp now) {
  if (now - window_since_ < kWindow || !measured_) return;  // what is not measured has not become quick
  measured_ = false;
  window_since_ = now;
  worst_before_ = worst_now_;
  late_before_ = late_now_;
  worst_now_ = Duration{0};
  late_now_ = 0;
}

double RoundTrip::worst_ms() const {
  return std::ceil(1e4 * seconds(worst())) / 10.0;
}

Duration RoundTrip::deadline(Timestamp now) const {
  if (now < patient_until_) return std::max(base_, kPatience);
  // half as long again, as answers vary; a quick link keeps what is configured
  const Duration measured = worst() * 3 / 2 + std::chrono::milliseconds(2);
  return worst() < base_ ? base_ : std::clamp(measured, base_, std::max(base_, kLatest));
}

}  // namespace colift::hal::barrett
