#pragma once

#include <algorithm>
#include <cmath>
#include <optional>

#include "hal/types/time.hpp"

namespace colift::hal {

/// The controller's sample time, as far as it may be believed. A step that a limiter allows is proportional
/// to it, and it comes in a datagram: believed is what lies between 1 and 100 ms (the range of friOpen) and
/// what the datagrams' arrivals agree with. Allocation-free.
class SamplePeriod {
 public:
  static constexpr double kShortest_s = 0.001, kLongest_s = 0.1;

  explicit SamplePeriod(double expected_s) : period_s_(expected_s) {}

  /// One datagram, `cycles` after the last one by its counter; `anew`: the first, or after a restart.
  /// `frozen`: it is commanded with this period, which does not change then.
  void packet(double claimed_s, Timestamp arrived_at, int cycles, bool anew, bool frozen) {
    const bool possible = claimed_s > 0.99 * kShortest_s && claimed_s < 1.01 * kLongest_s;  // a float
    claimed_s_ = possible ? std::optional(claimed_s) : std::nullopt;
    if (frozen && believed_) return begin(arrived_at);
    if (anew || !claimed_s_ || std::abs(*claimed_s_ - window_s_) > kAlike * window_s_) {
      window_s_ = claimed_s_.value_or(0.0);
      return begin(arrived_at);
    }
    cycles_ += cycles;
    if (cycles_ < kWindow) return;
    const double mean_s = seconds(arrived_at - since_) / cycles_;
    if (std::abs(mean_s - window_s_) <= kAgrees * window_s_ + kJitter_s) {
      period_s_ = window_s_;
      believed_ = true;
    }
    measured_s_ = mean_s;
    begin(arrived_at);
  }

  /// Time from one datagram to the next (s): what was expected, until one is believed.
  [[nodiscard]] double period_s() const { return period_s_; }
  /// What a step may use (s): the smaller of the period and of what the last datagram says.
  [[nodiscard]] double limit_s() const { return std::min(period_s_, claimed_s_.value_or(kShortest_s)); }
  /// Time between arrivals over the last window (s), where it disagrees with what is claimed.
  [[nodiscard]] std::optional<double> disagrees_s() const {
    if (!measured_s_ || std::abs(*measured_s_ - window_s_) <= kAgrees * window_s_ + kJitter_s)
      return std::nullopt;
    return measured_s_;
  }

 private:
  static constexpr int kWindow = 10;  // datagrams
  static constexpr double kAlike = 0.01, kAgrees = 0.25, kJitter_s = 0.0002;

  void begin(Timestamp at) {
    since_ = at;
    cycles_ = 0;
  }

  double period_s_, window_s_ = 0.0;  // window_s_: claimed in every datagram of the window
  std::optional<double> claimed_s_, measured_s_;
  bool believed_ = false;
  Timestamp since_{0};
  int cycles_ = 0;
};

}  // namespace colift::hal
