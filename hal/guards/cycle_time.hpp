#pragma once

#include <algorithm>
#include <cmath>
#include <optional>

#include "hal/types/time.hpp"

namespace colift::hal {

/// How far the arm's time moved from one state to the next, and how much of it one command may use. The
/// arm's own period is learned from two like intervals in a row; a longer one than before only from twenty,
/// so that a few late states in a row do not stretch the steps. When cycles were lost, a command gets the
/// time of one: what was missed is made up for by nobody.
class CycleTime {
 public:
  void reset() { *this = CycleTime{}; }

  /// Takes the next time stamp; returns the time since the last one (s), 0 for the first.
  double advance(Timestamp at) {
    since_s_ = last_ ? seconds(at - *last_) : 0.0;
    last_ = at;
    const bool alike = since_s_ > 0.0 && std::abs(since_s_ - before_s_) < kAlike * since_s_;
    alike_ = alike ? alike_ + 1 : 0;
    const bool longer = period_s_ > 0.0 && since_s_ > (1.0 + kAlike) * period_s_;
    if (alike && (!longer || alike_ >= kLonger)) period_s_ = since_s_;
    before_s_ = since_s_;
    return since_s_;
  }

  /// The arm's own period as it is known (s); 0 before.
  [[nodiscard]] double period_s() const { return period_s_; }
  [[nodiscard]] const std::optional<Timestamp>& last() const { return last_; }
  /// Between the last two time stamps (s).
  [[nodiscard]] double since_s() const { return since_s_; }
  /// What the command for the last time stamp may use (s).
  [[nodiscard]] double step_s() const { return period_s_ > 0.0 ? std::min(since_s_, period_s_) : since_s_; }

 private:
  static constexpr double kAlike = 0.1;
  static constexpr int kLonger = 20;
  std::optional<Timestamp> last_;
  int alike_ = 0;
  double since_s_ = 0.0, before_s_ = 0.0, period_s_ = 0.0;
};

}  // namespace colift::hal
