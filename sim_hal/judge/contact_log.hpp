#pragma once

#include <string>
#include <vector>

#include "sim_hal/judge/verdict.hpp"
#include "sim_hal/people/body_contact.hpp"

namespace colift::sim_hal {

/// Contacts of every millisecond as touches, each judged against its region's limits.
class ContactLog {
 public:
  void tick(double t_s, const std::vector<BodyContact>& contacts);
  void add_to(Verdict& verdict) const;
  /// Peak of what the robot itself did to anybody (N).
  [[nodiscard]] double robot_peak_n() const { return robot_peak_n_; }

 private:
  struct Touch {
    JudgedContact judged;
    BodyContact::By by = BodyContact::By::Robot;
    BodyRegion region = BodyRegion::Hand;
    double first_s = 0.0, last_s = 0.0;
    double transient_n = 0.0, clamped_n = 0.0;
    bool opposed = false;  // pressed against something else at least once
  };

  void add(double t_s, const BodyContact& contact, bool opposed);

  std::vector<Touch> touches_;
  double robot_peak_n_ = 0.0;
};

}  // namespace colift::sim_hal
