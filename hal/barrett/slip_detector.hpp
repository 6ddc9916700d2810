#pragma once

#include <array>
#include <cstdint>

#include "hal/hand.hpp"
#include "hal/types/time.hpp"

namespace colift::hal::barrett {

struct SlipLimits {
  double closed_rad = 0.03;  ///< A finger that closes this much further has lost what it held.
  double share = 0.5;        ///< Force or strain that falls to this share of what it was lately.
  double least_nm = 0.08;    ///< Below these there was nothing to lose.
  double least_n = 0.3;
};

/// Tells from what the fingers measure that the object leaves the grip. A drop has to show in two
/// measurements in a row, so that a single bad one is no alarm; the reference follows slow changes (lifting,
/// a moved load).
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
    double reference = 0.0;
    int below = 0;
  };
  bool drops(Trace& trace, double value, double least, double dt_s) const;

  SlipLimits limits_;
  std::array<double, kFingers> start_rad_{};
  std::array<Trace, kFingers> strain_{}, pad_{};
  Timestamp last_{0};
  bool started_ = false, slipped_ = false;
};

}  // namespace colift::hal::barrett
