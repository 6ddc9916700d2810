#pragma once

#include <string>
#include <vector>

#include "sim_hal/judge/verdict.hpp"
#include "sim_hal/people/body_contact.hpp"

namespace colift::sim_hal {

/// Contacts of every millisecond as touches, each judged against its region's limits.
class ContactLog {
 public:
  /// `robot_at_rest`: every joint has been slow for a while, up to this millisecond.
  void tick(double t_s, const std::vector<BodyContact>& contacts, bool robot_at_rest);
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
    bool at_rest = false;  // the robot was, when it began
    bool opposed = false;  // pressed against something else at least once
  };

  void add(double t_s, const BodyContact& contact, bool opposed, bool robot_at_rest);

  std::vector<Touch> touches_;
  double robot_peak_n_ = 0.0;
};

}  // namespace colift::sim_hal
