#pragma once

#include "hal/types/time.hpp"

namespace colift::control {

/// Times one stage after the other.
class Stopwatch {
 public:
  explicit Stopwatch(const hal::Clock& clock) : clock_(clock), last_(clock.now()) {}
  /// Since the last call, or the beginning (ms).
  double lap() {
    const hal::Timestamp now = clock_.now();
    const double ms = 1e3 * hal::seconds(now - last_);
    last_ = now;
    return ms;
  }

 private:
  const hal::Clock& clock_;
  hal::Timestamp last_;
};

}  // namespace colift::control
