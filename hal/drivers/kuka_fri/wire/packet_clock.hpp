#pragma once

#include <algorithm>
#include <cmath>

#include "hal/types/time.hpp"

namespace colift::hal {

/// When a datagram was measured: counted in sample times from the first arrival, so that the network's jitter
/// does not reach the controller of the arm. The two clocks drift apart (some 10 ppm); the earliest arrivals
/// of a window tell by how much, and it is made up for so slowly that no cycle shows it.
class PacketClock {
 public:
  /// The next datagram, `cycles` periods after the last one.
  Timestamp advance(int cycles, double period_s, Timestamp arrived_at) {
    const Duration by(std::llround(static_cast<double>(cycles) * period_s * 1e9));
    if (!started_) return start(arrived_at);
    now_ += by;
    earliest_ = std::min(earliest_, arrived_at - now_);
    if (++seen_ >= kWindow) {
      drift_ = earliest_ < -kDeadBand ? earliest_ : earliest_ > kDeadBand ? earliest_ : Duration::zero();
      earliest_ = Duration::max();
      seen_ = 0;
    }
    const Duration most(by.count() / kSlowest);
    const Duration step = std::clamp(drift_, -most, most);
    now_ += step;
    drift_ -= step;
    return now_;
  }

  /// A new count begins. Time does not run backwards.
  Timestamp start(Timestamp arrived_at) {
    now_ = started_ ? std::max(arrived_at, now_ + Duration(1'000'000)) : arrived_at;
    started_ = true;
    earliest_ = Duration::max();
    drift_ = Duration::zero();
    seen_ = 0;
    return now_;
  }

 private:
  static constexpr int kWindow = 500;
  static constexpr int kSlowest = 10000;  // 100 ppm
  static constexpr Duration kDeadBand{1'000'000};
  bool started_ = false;
  Timestamp now_{0};
  Duration earliest_ = Duration::max(), drift_{0};
  int seen_ = 0;
};

}  // namespace colift::hal
