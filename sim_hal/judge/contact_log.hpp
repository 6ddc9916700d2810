#pragma once

#include <optional>
#include <string>
#include <vector>

#include "sim_hal/judge/verdict.hpp"
#include "sim_hal/people/body_contact.hpp"

namespace colift::sim_hal {

/// What moves the robot when it is touched.
enum class RobotMotion {
  Driven,  ///< Its commands, or what is left of their speed.
  AtRest,  ///< Nothing: every joint has been slow for a while, or commands have put no energy into it.
  Pushed,  ///< It was at rest until a person pushed it, and no command has driven it since.
};

/// What the robot does while it is touched.
struct RobotDoes {
  RobotMotion motion = RobotMotion::AtRest;  ///< Up to this millisecond.
  bool stood = true;                         ///< It stands, or did until somebody pushed it.
  double commanded_j = 0.0;                  ///< CommandedEnergy::put_in_j().
  std::optional<Vec3> closes_at_W{};         ///< Where its hand is, while fingers close.
};

/// Contacts of every millisecond as touches, each judged against its region's limits.
class ContactLog {
 public:
  void tick(double t_s, const std::vector<BodyContact>& contacts, const RobotDoes& robot);
  void add_to(Verdict& verdict) const;
  /// Peak of what the robot itself did to anybody (N).
  [[nodiscard]] double robot_peak_n() const { return robot_peak_n_; }

 private:
  struct Touch {
    JudgedContact judged;
    BodyContact::By by = BodyContact::By::Robot;
    BodyRegion region = BodyRegion::Hand;
    bool left = false;
    double first_s = 0.0, pressed_s = 0.0, last_s = 0.0;  // begun; pressed without a pause since; last seen
    double transient_n = 0.0, clamped_n = 0.0;
    RobotMotion motion = RobotMotion::Driven;       // when it began
    RobotMotion peak_motion = RobotMotion::Driven;  // when it was hardest
    bool stood = false;                             // the robot, until somebody pushed it
    bool gripped = false;                           // by fingers that closed meanwhile
  };

  void add(double t_s, const BodyContact& contact, bool opposed, const RobotDoes& robot);

  std::vector<Touch> touches_;
  double robot_peak_n_ = 0.0;
};

}  // namespace colift::sim_hal
