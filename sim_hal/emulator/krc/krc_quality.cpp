#include "sim_hal/emulator/krc/krc_quality.hpp"

#include <cmath>

namespace colift::sim_hal {
namespace {

constexpr double kMissed = -1.0;

}  // namespace

KrcQuality::KrcQuality(const KrcQualityLimits& limits, hal::Duration cycle)
    : limits_(limits),
      cycle_s_(hal::seconds(cycle)),
      ring_(static_cast<std::size_t>(limits.window), kMissed) {}

void KrcQuality::note(double latency_s) {
  if (ring_[next_] >= 0.0) --answers_;
  if (latency_s >= 0.0) ++answers_;
  ring_[next_] = latency_s;
  next_ = (next_ + 1) % ring_.size();
}

void KrcQuality::answered(hal::Duration latency) {
  note(std::max(hal::seconds(latency), 0.0));
  in_a_row_ = 0;
}

void KrcQuality::missed() {
  note(kMissed);
  ++missed_;
  ++in_a_row_;
}

double KrcQuality::answer_rate() const {
  return static_cast<double>(answers_) / static_cast<double>(ring_.size());
}

double KrcQuality::latency_s() const {
  double sum = 0.0;
  for (const double latency : ring_)
    if (latency >= 0.0) sum += latency;
  return answers_ > 0 ? sum / answers_ : 0.0;
}

double KrcQuality::jitter_s() const {
  const double mean = latency_s();
  double sum = 0.0;
  for (const double latency : ring_)
    if (latency >= 0.0) sum += std::abs(latency - mean);
  return answers_ > 0 ? sum / answers_ : 0.0;
}

FriQuality KrcQuality::quality() const {
  // a rate of 99 in 100 is written as a number that no binary fraction meets
  const double rate = answer_rate() + 1e-9;
  if (rate < limits_.bad) return FriQuality::Unacceptable;
  if (rate < limits_.ok) return FriQuality::Bad;
  if (rate < limits_.perfect || latency_s() > limits_.slow_latency * cycle_s_) return FriQuality::Ok;
  return FriQuality::Perfect;
}

}  // namespace colift::sim_hal
