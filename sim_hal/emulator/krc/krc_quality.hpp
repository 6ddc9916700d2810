#pragma once

#include <vector>

#include "hal/types/time.hpp"
#include "sim_hal/emulator/krc/krc_wire.hpp"

namespace colift::sim_hal {

/// From how many answers on the KRC calls the link what. Only the window is public (average over the last 100
/// packets); the numbers are this emulator's own.
struct KrcQualityLimits {
  int window = 100;                              ///< Cycles.
  double perfect = 0.99, ok = 0.95, bad = 0.80;  ///< Smallest answer rate; below `bad`: unacceptable.
  double slow_latency = 0.9;                     ///< Mean latency over cycle that caps the quality at OK.
};

/// The KRC's statistics of its link. A cycle counts as answered when its own answer came before the next
/// measurement went out. The window begins with nothing but missed cycles.
class KrcQuality {
 public:
  explicit KrcQuality(const KrcQualityLimits& limits, hal::Duration cycle);

  void answered(hal::Duration latency);
  void missed();

  [[nodiscard]] FriQuality quality() const;
  [[nodiscard]] double answer_rate() const;
  /// Means over the answered cycles of the window (s); 0 without any.
  [[nodiscard]] double latency_s() const;
  [[nodiscard]] double jitter_s() const;  ///< Mean absolute deviation from the mean.
  [[nodiscard]] std::uint32_t missed_in_all() const { return missed_; }
  [[nodiscard]] int missed_in_a_row() const { return in_a_row_; }

 private:
  void note(double latency_s);  // negative: missed

  KrcQualityLimits limits_;
  double cycle_s_;
  std::vector<double> ring_;
  std::size_t next_ = 0;
  std::uint32_t missed_ = 0;
  int in_a_row_ = 0, answers_ = 0;
};

}  // namespace colift::sim_hal
