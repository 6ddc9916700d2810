#pragma once

#include <array>
#include <cstdint>

#include "hal/hand.hpp"
#include "hal/types/time.hpp"

namespace colift::hal::barrett {

struct SlipLimits {
  double closed_rad = 0.03;  ///< Fingers that close this much further, in the mean, have lost what they held.
  double share = 0.5;        ///< Force or strain that falls to this share of what it was lately.
  double min_nm = 0.08;      ///< Below these sums there was nothing to lose.
  double min_n = 0.3;
};

/// Tells from what the fingers measure that the object leaves the grip. Judged are all holding fingers
/// together: a weight that is lifted shifts from one finger to the next, but takes nothing from what presses
/// on the object; only where the grip itself gives way the sum falls, or all close. A drop has to show in two
/// measurements in a row, so that a single bad one is no alarm. The reference is smooth, and follows slow
/// changes (a moved load), but never above the grip's beginning: what the load adds to that comes and goes
/// without a slip.
class SlipDetector {
 public:
  explicit SlipDetector(const SlipLimits& limits) : limits_(limits) {}

  /// The grip as it is now is a good one; forgets an alarm.
  void start() { started_ = false, slipped_ = false; }

  /// One measurement of all fingers; NaN where there is none. Only fingers in `holding` count.
  void add(Timestamp at, const std::array<double, kFingers>& inner_rad,
           const std::array<double, kFingers>& strain_nm, const std::array<double, kFingers>& pad_n,
           const std::array<bool, kFingers>& holding);

  [[nodiscard]] bool slipped() const { return slipped_; }

 private:
  struct Trace {
    double begin = 0.0, reference = 0.0;
    std::array<bool, kFingers> of{};  ///< The fingers in it; with others it starts anew.
    int below = 0;
  };
  bool drops(Trace& trace, const std::array<double, kFingers>& values,
             const std::array<bool, kFingers>& holding, double least, double dt_s) const;

  SlipLimits limits_;
  std::array<double, kFingers> start_rad_{};
  Trace strain_, pad_;
  int closing_ = 0;
  Timestamp last_{0};
  bool started_ = false, slipped_ = false;
};

}  // namespace colift::hal::barrett
